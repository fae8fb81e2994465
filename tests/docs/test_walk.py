"""The walk of docs/add-an-exercise.md works as it stands: its files, its commands, its output."""

from __future__ import annotations

import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from documents import ROOT

PAGE = (ROOT / "docs/add-an-exercise.md").read_text("utf-8")
WALK = PAGE.partition("\n## The walk")[2].partition("\n## The proof")[0]
FILE = re.compile(  # a paragraph that begins with a path, then a fence
    r"^`([\w./-]+)`(?:(?!\n```).)*?\n\n```(?!text)\w+\n(.*?)^```$", re.MULTILINE | re.DOTALL
)
COMMANDS = WALK.partition("### Run it\n")[2]
PROOF = re.search(r"^```text\n(.*?)^```$", COMMANDS, re.MULTILINE | re.DOTALL)
WRONG = "course grade stop_line build/wrong"  # its exit code is 1: less than full marks


@pytest.fixture(scope="module")
def copy(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a copy of the project with the walk's files in it."""
    folder = tmp_path_factory.mktemp("walk")
    for room in ("grader", "sim", "exercises", "solutions"):
        shutil.copytree(ROOT / room, folder / room, ignore=shutil.ignore_patterns("__pycache__"))
    for name, text in FILE.findall(WALK):
        assert not (folder / name).exists(), name
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text, "utf-8")
    return folder


def run(copy: Path, command: str) -> subprocess.CompletedProcess[str]:
    program, *arguments = shlex.split(command)
    return subprocess.run(
        [str(Path(sys.executable).parent / Path(program).name), *arguments],
        cwd=copy, env={**os.environ, "PYTHONPATH": str(copy)},
        capture_output=True, text=True, timeout=300, check=False,
    )  # fmt: skip


@pytest.mark.long
def test_the_walk_works_as_it_stands(copy: Path) -> None:
    commands = re.findall(r"(?m)^    (\.venv/bin/.+)$", COMMANDS)
    assert len(commands) == 6
    done = None
    for command in commands:
        done = run(copy, command)
        said = f"{command}\n{done.stdout}{done.stderr}"
        assert done.returncode == int(WRONG in command), said
    assert (copy / "exercises/stop_line/stop_line_agent.py").is_file()

    assert done is not None
    assert PROOF is not None
    printed = [line.rstrip() for line in done.stdout.splitlines()]
    quoted = [line.rstrip() for line in PROOF[1].splitlines()]
    assert printed[: len(quoted)] == quoted
    assert printed[-1] == "0 objections"
