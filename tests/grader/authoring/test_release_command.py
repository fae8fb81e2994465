"""course release, in a process of its own."""

from __future__ import annotations

from pathlib import Path

import pytest
from command_line import course

# What is made for a release is tested with the whole of it: tests/notebooks/test_handouts.py.


def test_the_command_releases_one_exercise(tmp_path: Path) -> None:
    week = tmp_path / "week"
    done = course("release", week, "--exercise", "3", "--student-package", "--plain")
    assert (done.code, done.err) == (0, "")
    assert done.out == f"Students' material: {week}\nThe same, packed: {week}.zip\n"
    assert (week / "exercises" / "goal_seeking").is_dir()


@pytest.mark.long
def test_the_command_says_which_skeletons_give_something_away(tmp_path: Path) -> None:
    done = course("release", tmp_path / "all", "--plain")
    assert done.code == 0
    assert "Note: exercises/trend_memory/trend_agent.py has lines of" in done.err


def test_the_command_refuses_in_one_line(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("mine")
    done = course("release", tmp_path)
    assert (done.code, done.out, done.err.count("\n")) == (2, "", 1)
    assert "new or empty" in done.err
