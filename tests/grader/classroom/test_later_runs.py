"""A later run into the same folder: what it says of the one before, and what it refuses."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import pytest
from fake_class import FILE, SLUG, fair
from handing_in import put
from marked_class import give, points, scores

from grader.course.exercises import find_exercise
from grader.errors import InputError
from grader.lms.people import Roster
from grader.lms.sheets import read_roster

SECRET = b"0123456789abcdef"
GRADEBOOK = """Student,ID,SIS Login ID,Section,Homework (71)
    Points Possible,,,,50
"Lee, Ann",1,ann,A,
"Ray, Bob",2,bob,B,
"Zed, Nob",3,nob,B,
"""


@pytest.fixture
def roster(tmp_path: Path) -> Roster:
    (tmp_path / "gradebook.csv").write_text(GRADEBOOK)
    return read_roster([tmp_path / "gradebook.csv"])


def test_what_was_hidden_is_not_shown_by_a_slip(grade_class: Any) -> None:
    grade_class(hide="details")
    with pytest.raises(InputError, match="give --hide details again, or --hide nothing"):
        grade_class()
    grade_class(hide="nothing")
    assert not any("--hide" in line for line in grade_class()[2].lines)


def test_a_secret_that_is_left_out_or_another_is_refused(grade_class: Any) -> None:
    grade_class(secret=SECRET)
    for wrong in (None, b"another secret of 16 bytes"):
        with pytest.raises(InputError, match="--secret: expected the file that this class"):
            grade_class(secret=wrong)
        with pytest.raises(InputError, match="--secret"):
            grade_class(fair, regrade=True, secret=wrong)
    assert grade_class(secret=SECRET)[1].students == []


def test_another_class_is_refused_and_who_is_gone_is_said(
    grade_class: Any, handed_in: Path, roster: Roster
) -> None:
    grade_class(roster=roster)  # who handed in nothing is the same in any download
    shutil.move(handed_in / "bob", handed_in / "bo")
    with pytest.raises(InputError, match="nothing in it is of 1 whose work is graded: Bob Ray"):
        grade_class(roster=roster)
    said = grade_class(roster=roster, drop=True)[2].lines
    assert any("dropped, because nothing of them is there: Bob Ray" in line for line in said)
    for each in ("ann", "bo", "eve"):
        shutil.rmtree(handed_in / each)
    put(handed_in, **{f"zoe/{FILE}": "# mine\n"})
    with pytest.raises(InputError, match=r"of its 3 students \(Ann Lee, bo, eve\) nobody is in"):
        grade_class(roster=roster)


def test_who_is_held_stays_so_when_others_are_added(
    grade_class: Any, handed_in: Path, tmp_path: Path, roster: Roster
) -> None:
    (handed_in / "bob" / FILE).rename(handed_in / "bob" / "notes.md")
    grade_class(roster=roster)
    for each in ("ann", "bob", "eve"):
        (handed_in / each).rename(tmp_path / each)
    put(handed_in, **{f"nob/{FILE}": "# late\n"})
    said = grade_class(roster=roster, add=True)[2].lines
    assert scores(tmp_path / "out")["Bob Ray"]["state"] == "held"
    assert any("Kept as they were" in line and "Bob Ray" in line for line in said)
    assert "notes.md" in (tmp_path / "out" / "intake.csv").read_text()
    (tmp_path / "bob").rename(handed_in / "bob")
    (handed_in / "bob" / "notes.md").rename(handed_in / "bob" / FILE)
    grade_class(roster=roster, add=True)
    assert scores(tmp_path / "out")["Bob Ray"]["state"] == "graded"


def test_a_mark_follows_who_hands_in_later(
    grade_class: Any, handed_in: Path, tmp_path: Path, roster: Roster
) -> None:
    """With a submission and without a student is called by the roster's name."""
    out = tmp_path / "out"
    grade_class(roster=roster)
    give(out, "3", 30)
    put(handed_in, **{f"nob/{FILE}": "# late\n"})
    grade_class(roster=roster)
    assert "Ann Lee" in (out / "class.html").read_text()
    assert (points(out)["Nob Zed"], scores(out)["Nob Zed"]["points_as_graded"]) == ("30", "100")
    page = (out / "class.html").read_text()
    assert "made when nothing was handed in, and still counts; look at it again: Nob Zed" in page
    shutil.rmtree(handed_in / "nob")
    (tmp_path / "two.csv").write_text(GRADEBOOK.replace('"Zed, Nob",3,nob', '"Ono, Yo",4,yo'))
    grade_class(roster=read_roster([tmp_path / "two.csv"]), drop=True)
    assert "is about somebody who is not in the class: Nob Zed" in (out / "class.html").read_text()


def test_earlier_years_are_downloads_or_classes_graded_here(
    grade_class: Any, handed_in: Path, tmp_path: Path
) -> None:
    """Ann hands in what Bob handed in last year, with other names."""
    source = (find_exercise(SLUG).solutions / "variants" / "compact.py").read_bytes()
    (handed_in / "bob" / FILE).write_bytes(source)
    grade_class()
    last_year, download = tmp_path / "2025", tmp_path / "2024"
    (tmp_path / "out").rename(last_year)
    handed_in.rename(download)
    (handed_in / "ann").mkdir(parents=True)
    (handed_in / "ann" / FILE).write_bytes(source.replace(b"readings", b"mine"))
    for folder in (last_year, download):
        grade_class(earlier=(folder,))
        (page,) = (tmp_path / "out" / "likeness" / SLUG).glob("1.html")
        said = (tmp_path / "out" / "class.html").read_text("utf-8")
        assert f"likeness/{SLUG}/1.html" in said
        assert "mine.append" in page.read_text("utf-8")
    (tmp_path / "empty" / "ann").mkdir(parents=True)
    with pytest.raises(InputError, match="empty"):
        grade_class(earlier=(tmp_path / "empty",))
