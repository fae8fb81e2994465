"""Packages of Pyodide's release: those that are needed, and only the files that it was made of."""

import hashlib
import json
from pathlib import Path

import pytest

from grader.errors import GraderError
from workspace.build import released

NEEDS = {"matplotlib": ["python_dateutil"], "python-dateutil": ["six"], "six": [], "pandas": []}


def test_what_is_needed_is_there_and_has_the_hash_of_the_lock_file(tmp_path: Path) -> None:
    modules, cache = tmp_path / "modules", tmp_path / "cache"
    (modules / "pyodide").mkdir(parents=True)
    (cache / "pyodide").mkdir(parents=True)
    packages = {}
    for name, depends in NEEDS.items():
        content = name.encode()
        (cache / "pyodide" / f"{name}.whl").write_bytes(content)
        sha256 = hashlib.sha256(content).hexdigest()
        packages[name] = {"file_name": f"{name}.whl", "sha256": sha256, "depends": depends}
    lock = modules / "pyodide" / "pyodide-lock.json"
    lock.write_text(json.dumps({"packages": packages}))

    found = released(["matplotlib"], cache, modules)
    assert sorted(found) == ["matplotlib", "python-dateutil", "six"]
    (cache / "pyodide" / "six.whl").write_bytes(b"another")
    with pytest.raises(GraderError, match=r"six\.whl: expected SHA-256 .*, got .*; delete it"):
        released(["matplotlib"], cache, modules)
    assert released(["pandas"], cache, modules)
