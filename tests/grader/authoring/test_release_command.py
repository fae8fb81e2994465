"""course release, in a process of its own."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

# What is made for a release is tested with the whole of it: tests/notebooks/test_handouts.py.


def course_release(*arguments: object) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "grader.cli", "release", *map(str, arguments)],
        capture_output=True, text=True, timeout=60, check=False,
    )  # fmt: skip


def test_the_command_releases_one_exercise(tmp_path: Path) -> None:
    done = course_release(tmp_path / "week", "--exercise", "3", "--student-package", "--plain")
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.split() == [
        *f"Students' material: {tmp_path / 'week'}".split(),
        *f"The same, packed: {tmp_path / 'week.zip'}".split(),
    ]
    assert (tmp_path / "week" / "exercises" / "goal_seeking").is_dir()


@pytest.mark.long
def test_the_command_says_which_skeletons_give_something_away(tmp_path: Path) -> None:
    done = course_release(tmp_path / "all", "--plain")
    assert done.returncode == 0
    assert "Note: exercises/trend_memory/trend_agent.py has lines of" in done.stderr


def test_the_command_refuses_in_one_line(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("mine")
    done = course_release(tmp_path)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
    assert "new or empty" in done.stderr
