"""The walk of docs/add-an-exercise.md works as it stands: `course new`, its commands, its output.

A whole exercise is made in a copy of the project, read, graded, proven, linted, and taken back.
"""

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
FILE = re.compile(  # a paragraph that begins with a path, then a fence: the file or a part of it
    r"^`([\w./-]+)`(?:(?!\n\n).)*\n\n```(?!text)\w+\n(.*?)^```$", re.MULTILINE | re.DOTALL
)
COMMANDS = WALK.partition("### Run it\n")[2]
PROOF = re.search(r"^```text\n(.*?)^```$", COMMANDS, re.MULTILINE | re.DOTALL)
WRONG = "course grade stop_line build/wrong"  # its exit code is 1: less than full marks
BIN = Path(sys.executable).parent
GIT = ["git", "-c", "user.name=test", "-c", "user.email=test@example.org", "-c", "core.hooksPath="]
LIMIT = 1200  # [s] of a command; mypy has no cache here


def run(copy: Path, command: str) -> subprocess.CompletedProcess[str]:
    program, *arguments = shlex.split(command)
    return subprocess.run(
        [str(BIN / Path(program).name), *arguments],
        cwd=copy, env={**os.environ, "PYTHONPATH": str(copy)},
        capture_output=True, text=True, timeout=LIMIT, check=False,
    )  # fmt: skip


def recipe(copy: Path, target: str) -> list[str]:
    """Return the commands of a `make` target; make itself would install the copy.

    Without the pitfalls: their nodes import the course as it is installed, which is no copy.
    """
    text = (copy / "Makefile").read_text("utf-8")
    found = re.search(rf"(?m)^{target}:.*\n((?:\t.+\n)+)", text)
    assert found is not None
    return [line.strip() for line in found[1].splitlines() if "pitfalls" not in line]


def git(copy: Path, *words: str) -> str:
    done = subprocess.run([*GIT, *words], cwd=copy, capture_output=True, text=True, check=True)
    return done.stdout


@pytest.fixture
def copy(tmp_path: Path) -> Path:
    """Return a copy of the project as git knows it."""
    if shutil.which("git") is None or not (ROOT / ".git").exists():
        pytest.skip("no git, or no checkout")
    for name in git(ROOT, "ls-files", "-z").rstrip("\0").split("\0"):
        if (ROOT / name).is_file():
            (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / name, tmp_path / name)
    git(tmp_path, "init", "-q")
    git(tmp_path, "add", "--all")
    git(tmp_path, "commit", "-q", "-m", "as it was")
    return tmp_path


@pytest.mark.long
def test_the_walk_works_as_it_stands(copy: Path) -> None:
    (first, *commands) = re.findall(r"(?m)^    ((?:\.venv/bin/|make ).+)$", WALK)
    assert first == ".venv/bin/course new stop_line"
    assert len(commands) == 6
    assert commands[-1] == "make lint"
    done = run(copy, first)
    assert done.returncode == 0, done.stderr

    quoted = FILE.findall(WALK)
    assert len(quoted) == 7
    for name, text in quoted:
        assert text in (copy / name).read_text("utf-8"), name

    for command in [*commands[:-1], *recipe(copy, "lint")]:
        done = run(copy, command)
        said = f"{command}\n{done.stdout}{done.stderr}"
        assert done.returncode == int(WRONG in command), said
        if "proof" in command:
            assert PROOF is not None
            printed = [line.rstrip() for line in done.stdout.splitlines()]
            wanted = [line.rstrip() for line in PROOF[1].splitlines()]
            assert printed[: len(wanted)] == wanted
            assert printed[-1] == "0 objections"

    new = git(copy, "status", "--porcelain", "--untracked-files=all")
    assert "solutions/stop_line/design.md" in new
    git(copy, "checkout", "--quiet", ".")
    git(copy, "clean", "-d", "--force", "--quiet")
    assert git(copy, "status", "--porcelain") == ""
    assert "stop_line" not in run(copy, ".venv/bin/course list").stdout
