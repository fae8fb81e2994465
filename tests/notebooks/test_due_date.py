"""A due date is stored as README writes it, by nbgrader's own command, wherever one is."""

import logging
import os
import re
import time
from datetime import UTC, datetime
from pathlib import Path

import pytest
from nbformat import v4
from nbgrader_kit import gradebook, nbgrader

from grader.nbgrader.autograde import FILE, JudgeNodes
from grader.nbgrader.configuration import find_programs
from grader.notebook.build import NOTEBOOKS

README = (NOTEBOOKS / "README.md").read_text("utf-8")
SAID = re.findall(r'^ {4}nbgrader db assignment add (\w+) --duedate=("?)(.+)\2$', README, re.M)


def stored(folder: Path, assignment: str) -> datetime:
    with gradebook(folder) as book:
        found: datetime = book.find_assignment(assignment).duedate
        return found.replace(tzinfo=UTC)


def test_the_line_of_the_readme(tmp_path: Path) -> None:
    ((assignment, _, text),) = SAID
    (tmp_path / "nbgrader_config.py").write_text(
        "from grader.nbgrader import configure\nc = get_config()\nconfigure(c)\n", "utf-8"
    )
    nbgrader(tmp_path, "db", "assignment", "add", assignment, f"--duedate={text}")
    assert datetime.fromisoformat(text).utcoffset()
    assert stored(tmp_path, assignment) == datetime.fromisoformat(text)


def test_a_due_date_with_any_offset_is_meant_and_an_odd_one_is_told(
    tmp_path: Path, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What README says of a blank is what nbgrader does."""
    monkeypatch.setenv("PATH", os.environ["PATH"])
    find_programs()
    text, offset = SAID[0][2][:-6], SAID[0][2][-6:]
    assert datetime.fromisoformat(f"{text}{offset}").utcoffset()
    odd = f"{text.replace('T', ' ')[:-3]} {offset.replace(':', '')}"
    due = {each: f"{text}{each}" for each in (offset, "-05:00", "+05:30", "+12:45", "Z")} | {
        "odd": odd
    }
    with gradebook(tmp_path) as book:
        for number, (_, told) in enumerate(due.items()):
            book.update_or_create_assignment(f"week{number}", duedate=told)
            book.update_or_create_notebook("loop", f"week{number}")
    right = [stored(tmp_path, f"week{n}") == datetime.fromisoformat(told)
             for n, told in enumerate(due.values())]  # fmt: skip
    assert right == [True] * 5 + [False]
    about = {
        "db_url": f"sqlite:///{tmp_path / 'gradebook.db'}",
        "notebook": "loop",
        "student": "ann",
    }
    caplog.set_level(logging.INFO, "due")
    monkeypatch.setenv("TZ", "Asia/Kolkata")
    time.tzset()
    for _ in ("ann", "bob"):
        for number in range(len(due)):
            place = {"nbgrader": about | {"assignment": f"week{number}"}, FILE: str(tmp_path / "x")}
            JudgeNodes(log=logging.getLogger("due")).preprocess(v4.new_notebook(), place)
    monkeypatch.undo()
    time.tzset()
    *dates, told = caplog.messages  # once for a class
    assert dates[0] == "week0 is due at 2027-01-15 17:00:00 UTC, 2027-01-15 22:30:00 IST here"
    assert len(dates) == len(due)
    assert told.startswith("week5 is due at 2027-01-15 17:58:20 UTC (2027-01-15 23:28:20 IST here)")
    assert "nbgrader db assignment add week5 --duedate=2027-01-15T18:00:00+01:00" in told
