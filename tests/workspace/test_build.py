"""What a page is built of: the packages of Pyodide's release that it needs, and its weight."""

import hashlib
import json
from pathlib import Path

import pytest

from grader.errors import GraderError
from workspace.build import MOST, check_weight, released

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


def test_a_workspace_that_weighs_too_much_is_refused(tmp_path: Path) -> None:
    for name, size in (("page.js", 1000), ("pyodide/python.pack", MOST - 1000)):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        with (tmp_path / name).open("wb") as file:
            file.truncate(size)
    assert check_weight(tmp_path) == MOST
    (tmp_path / "more").write_bytes(b"1")
    with pytest.raises(GraderError, match=r"12,000,000 bytes .* got 12,000,001; leave out"):
        check_weight(tmp_path)
