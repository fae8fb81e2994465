"""The wheel beside a release's notebooks, and the address that they are told."""

import json
import os
from pathlib import Path

import pytest

from grader.authoring.carried import built_wheel, carried, what_lacks
from grader.notebook.bootstrap import BOOTSTRAP

ADDRESS = "https://university.example/rclpy_agents_course-0.1.0-py3-none-any.whl"
CELL = {"cells": [{"source": [line + "\n" for line in BOOTSTRAP.splitlines()]}]}
FILES = {"notebooks/01_loop.ipynb": json.dumps(CELL).encode(), "lesson/index.html": b"<p>"}


@pytest.fixture
def root(tmp_path: Path) -> Path:
    """A checkout with a wheel of its version, and one of another."""
    (tmp_path / "pyproject.toml").write_text('[project]\nname = "a-course"\nversion = "1.2"\n')
    (tmp_path / "dist").mkdir()
    for version in ("1.1", "1.2"):
        (tmp_path / "dist" / f"a_course-{version}-py3-none-any.whl").write_text(version)
    (tmp_path / "grader").mkdir()
    (tmp_path / "grader" / "code.py").touch()
    os.utime(tmp_path / "grader" / "code.py", (1, 1))
    return tmp_path


def test_the_wheel_of_this_version_goes_beside_the_notebooks(root: Path) -> None:
    wheel = built_wheel(root)
    assert wheel is not None
    found = carried(FILES, wheel, "")
    assert found == {**FILES, "notebooks/a_course-1.2-py3-none-any.whl": b"1.2"}
    assert what_lacks(wheel, "", root) == ""


def test_without_notebooks_there_is_no_wheel(root: Path) -> None:
    assert carried({"lesson/index.html": b""}, built_wheel(root), "") == {"lesson/index.html": b""}


def test_it_is_said_what_notebooks_will_lack(root: Path) -> None:
    wheel = built_wheel(root)
    assert wheel is not None
    os.utime(root / "grader" / "code.py", (4e9, 4e9))
    assert "is older than the course; run `make wheel`" in what_lacks(wheel, "", root)
    wheel.unlink()
    assert built_wheel(root) is None
    assert "the notebooks will ask for it; run `make wheel`" in what_lacks(None, "", root)
    assert what_lacks(None, ADDRESS, root) == ""
