"""A later run into the same folder: what it says of the one before, and what it refuses."""

import shutil
from pathlib import Path
from typing import Any

import pytest
from fake_class import FILE, SLUG, fair
from handing_in import put, roster_of
from marked_class import give, points, scores

from grader.classroom.results.sources import write_sources
from grader.errors import InputError
from grader.lms.people import Roster

SECRET = b"0123456789abcdef"
GRADEBOOK = """Student,ID,SIS Login ID,Section,Homework (71)
    Points Possible,,,,50
"Lee, Ann",1,ann,A,
"Ray, Bob",2,bob,B,
"Zed, Nob",3,nob,B,
"""


@pytest.fixture
def roster(tmp_path: Path) -> Roster:
    return roster_of(tmp_path, GRADEBOOK)


def test_a_later_run_knows_the_gradebooks_column(
    grade_class: Any, roster: Roster, tmp_path: Path
) -> None:
    for columns in (f"{SLUG}=Homework (71)",), ():
        grade_class(roster=roster, columns=columns)
        assert "Homework (71)" in (tmp_path / "out" / "canvas" / f"{SLUG}.csv").read_text()


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
    other = GRADEBOOK.replace('"Zed, Nob",3,nob', '"Ono, Yo",4,yo')
    grade_class(roster=roster_of(tmp_path / "two", other), drop=True)
    assert "is about somebody who is not in the class: Nob Zed" in (out / "class.html").read_text()


def test_what_was_handed_in_lies_whole_in_a_folder_for_each_student(
    grade_class: Any, handed_in: Path, tmp_path: Path
) -> None:
    """Also what likeness once left out: an __init__, a test, text that is executed."""
    package = {"lib/__init__.py": "def node(): ...\n", "test_it.py": "x = 1\n", "agent.txt": "y\n"}
    put(handed_in, **{f"bob/{name}": text for name, text in package.items()})
    grade_class()
    folder = tmp_path / "out" / "sources" / SLUG
    texts = {file.relative_to(folder).as_posix() for file in folder.rglob("*") if file.is_file()}
    assert {f"class/bob/{name}" for name in (FILE, *package)} | {f"class/ann/{FILE}"} <= texts
    assert {f"handed_out/{FILE}", f"course/solutions/{FILE}", "course/checks/contract.py"} <= texts
    assert "course/models/features.py" in texts
    assert (folder / "class" / "bob" / "agent.txt").read_text() == "y\n"

    shutil.rmtree(handed_in / "bob" / "lib")
    grade_class()
    assert not (folder / "class" / "bob" / "lib").exists()


def test_a_path_that_leads_out_of_a_students_folder_stays_in_it(tmp_path: Path) -> None:
    names = ("../../up.py", "/etc/absolute.py", "a/../../b.py")
    paths = write_sources(tmp_path / "sources", "ann", SLUG, dict.fromkeys(names, b"x"))
    own = tmp_path / "sources" / SLUG / "class" / "ann"
    assert [path.relative_to(own).as_posix() for path in paths] == [
        "up.py", "etc/absolute.py", "a/b.py"
    ]  # fmt: skip
