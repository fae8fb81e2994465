"""A host imports what it uses: an editable install brings modules along that a wheel doesn't."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
FILES = sorted(path for room in ("grader", "rclpy_portable", "sim")
               for path in (ROOT / room).rglob("*.py") if "_ros" not in path.parts)  # fmt: skip
SUBMODULES = {"util", "abc", "machinery", "metadata", "resources"}


@pytest.mark.parametrize("package", ["importlib"])
def test_submodules_are_imported_by_who_uses_them(package: str) -> None:
    bad = []
    for path in FILES:
        tree = ast.parse(path.read_text("utf-8"))
        imported = {a.name for n in ast.walk(tree) if isinstance(n, ast.Import) for a in n.names}
        used = {
            f"{package}.{node.attr}"
            for node in ast.walk(tree)
            if isinstance(node, ast.Attribute)
            and isinstance(node.value, ast.Name)
            and (node.value.id, node.attr in SUBMODULES) == (package, True)
        }
        bad += [f"{path.relative_to(ROOT)}: {name}" for name in sorted(used - imported)]
    assert bad == []
