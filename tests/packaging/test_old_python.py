"""Who has an old Python reads one sentence that says so."""

import ast
import contextlib
import importlib.metadata
import subprocess
import sys
import types
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.specifiers import SpecifierSet

from grader.authoring.release import contents
from grader.course.exercises import ROOT

DEBIAN = "3.11.2"
OLD = (3, 10, 13, "final", 0)


def told(text: str, monkeypatch: pytest.MonkeyPatch) -> str:
    """Run a module as an old Python would, as far as it comes; return what it ends with."""
    ast.parse(text, feature_version=(3, 8))
    with monkeypatch.context() as patched:
        patched.setattr(sys, "version_info", OLD)
        with pytest.raises(SystemExit) as ended:
            exec(compile(text, "module", "exec"), types.ModuleType("module").__dict__)
    return str(ended.value)


def test_the_command_says_it(monkeypatch: pytest.MonkeyPatch) -> None:
    said = told((ROOT / "grader" / "__init__.py").read_text("utf-8"), monkeypatch)

    assert said.startswith("course: expected Python 3.11 to 3.14, but this is 3.10 (")
    assert "python3.12 -m venv" in said


@pytest.mark.parametrize("where", ["checkout", "release"])
def test_pip_says_it(where: str, monkeypatch: pytest.MonkeyPatch) -> None:
    text = (ROOT / ".ci" / "course_backend.py").read_text("utf-8")
    if where == "release":
        text = contents(["obstacle_avoidance"])["course_setup.py"].decode()

    assert told(text, monkeypatch) == (
        "expected Python 3.11 to 3.14, but this is 3.10; take a newer one"
    )


def test_every_pinned_version_takes_the_oldest_python() -> None:
    """Debian 12's: who has it reads ResolutionImpossible for a pin that wants a newer 3.11."""
    lines = (ROOT / "constraints.txt").read_text("utf-8").splitlines()
    pins = [Requirement(line) for line in lines if line and not line.startswith("#")]
    wrong = []
    for pin in pins:
        with contextlib.suppress(importlib.metadata.PackageNotFoundError):
            found = importlib.metadata.metadata(pin.name)
            wants = SpecifierSet(found.get("Requires-Python") or "")
            if found["Version"] in pin.specifier and DEBIAN not in wants:
                wrong.append(f"{pin}: {wants}")

    assert wrong == []


def test_make_says_it(tmp_path: Path) -> None:
    (tmp_path / "Makefile").write_bytes((ROOT / "Makefile").read_bytes())
    for name in ("pyproject.toml", "constraints.txt"):
        (tmp_path / name).touch()
    old = tmp_path / "python3.10"
    old.write_text('#!/bin/sh\n[ "$1" = -V ] && echo Python 3.10.13 && exit\nexit 1\n')
    old.chmod(0o755)

    done = subprocess.run(
        ["make", f"PYTHON={old}", "setup"], cwd=tmp_path, capture_output=True, text=True,
        check=False,
    )  # fmt: skip

    assert done.returncode == 2
    expected = f"expected Python 3.11 - 3.14, but {old} is Python 3.10.13; try: make "
    assert expected + "PYTHON=python3.12 setup" in done.stderr
