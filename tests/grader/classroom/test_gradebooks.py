"""Downloads taken in, and gradebook files read by the rules of the platforms that import them."""

import csv
import io
import zipfile
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from handing_in import AGENT, put
from importers import Canvas, MoodleAssignment
from made_results import book as book_of
from made_results import check, result

from grader.classroom.amendments.marks import tasks_of
from grader.classroom.intake.candidates import find_class
from grader.classroom.options import Options
from grader.classroom.results.options import ResultOptions, column_titles
from grader.classroom.results.write import write_results
from grader.classroom.row import ABSENT, StoredResult
from grader.errors import InputError
from grader.lms.book import Book, Handed, StudentRow
from grader.lms.canvas import canvas_csv
from grader.lms.moodle import worksheet_csv
from grader.lms.sheets import read_roster

SLUG = "obstacle_avoidance"
(TASK,) = tasks_of([result("ann")])


def graded(student: str, points: int = 60) -> StoredResult:
    return result(student, check("a", "pass", points), check("b", "fail", 100 - points))


def absent(student: str) -> StoredResult:
    return replace(result(student), state=ABSENT)


def taken(
    place: Path, names: Iterable[str], *sheets: str
) -> tuple[list[StoredResult], dict[str, Any]]:
    """A class as intake makes it of a download: who handed in has 60 points, and Bob 37."""
    put(place / "in", *names)
    tables = {f"{n}.csv": text for n, text in enumerate(sheets)}
    roster = read_roster([put(place, **tables) / name for name in tables])
    options = Options(exercises=(SLUG,), roster=roster)
    found = find_class([place / "in"], place / "scratch", options)
    results = [
        graded(student, 37 if "Bob" in student else 60) if one.files else absent(student)
        for (student, _), one in found.candidates.items()
    ]
    return results, {"students": {row.student: row for row in found.students}, "roster": roster}


# --- Canvas --------------------------------------------------------------------------------------


@pytest.fixture
def canvas() -> Canvas:
    return Canvas(
        users={
            11: ("Lee, Carla", "clee"), 12: ("Peters, Dan", "@dan"), 13: ("=Sum, Al", "=x"),
            14: ("Lee, Carla", "clee2"), 15: ("Excused, Eve", "eve"), 16: ("Un, Signed", "un"),
            17: ("Not, Here", "not"),
        },
        assignments={71: ("Week 1: Obstacle avoidance", "100"), 72: ("Goal seeking", "10")},
        scores={(11, 71): "55", (14, 71): "80", (15, 71): "EX", (17, 71): "30", (11, 72): "9"},
        unassigned={(16, 71)},
    )  # fmt: skip


NAMES = {11: "leecarla", 12: "petersdan", 13: "sumal", 15: "excusedeve", 16: "unsigned"}
UPLOADS = tuple(f"{name}_{id_}_90{id_}_{AGENT}" for id_, name in NAMES.items())


def canvas_book(canvas: Canvas, tmp_path: Path, *columns: str) -> Book:
    results, about = taken(tmp_path, UPLOADS, canvas.export())
    return book_of(results, **about, columns=column_titles(columns))


def test_canvas_changes_what_was_graded_and_nothing_else(canvas: Canvas, tmp_path: Path) -> None:
    book = canvas_book(canvas, tmp_path)
    text = canvas_csv(book, TASK)
    assert text is not None
    canvas.load(text)
    assert canvas.changes == {(11, 71): "60", (12, 71): "60", (13, 71): "60"}
    assert not (canvas.new_users or canvas.new_assignments or canvas.new_points)
    assert any("excused in Canvas: Eve Excused" in remark for remark in book.remarks)
    assert any("not assigned to them in Canvas: Signed Un" in r for r in book.remarks)
    cells = list(csv.reader(io.StringIO(text)))
    assert cells[0] == [
        "Student", "ID", "SIS User ID", "SIS Login ID", "Section",
        "Week 1: Obstacle avoidance (71)",
    ]  # fmt: skip
    assert sorted(line[0] for line in cells[1:]) == ["'=Sum, Al", "Lee, Carla", "Peters, Dan"]
    assert {line[3] for line in cells[1:]} == {"clee", "@dan", "=x"}  # ids stay as they are


def test_canvas_points_are_scaled_to_the_column(canvas: Canvas, tmp_path: Path) -> None:
    book = canvas_book(canvas, tmp_path, "1=Goal seeking")
    canvas.load(canvas_csv(book, TASK) or "")
    assert canvas.changes[11, 72] == canvas.changes[12, 72] == "6"
    assert not canvas.new_points
    assert any("scaled from 100 to the 10" in remark for remark in book.remarks)


def test_canvas_makes_an_assignment_it_has_not(canvas: Canvas, tmp_path: Path) -> None:
    canvas.assignments = {72: ("Goal seeking", "10")}
    book = canvas_book(canvas, tmp_path)
    canvas.load(canvas_csv(book, TASK) or "")
    assert canvas.new_assignments == ["Obstacle avoidance"]
    assert canvas.new_points == {-1: "100"}
    assert {user for user, _ in canvas.changes} == NAMES.keys()
    assert any("--column '1=TITLE'" in remark for remark in book.remarks)


def test_canvas_ids_of_the_download_do_without_a_roster(canvas: Canvas, tmp_path: Path) -> None:
    results, about = taken(tmp_path, UPLOADS)
    canvas.assignments = {71: ("Obstacle avoidance", "100")}
    canvas.load(canvas_csv(book_of(results, **about), TASK) or "")
    assert {user for user, _ in canvas.changes} == {11, 12, 13, 15}
    assert not (canvas.new_users or canvas.new_assignments or canvas.new_points)


def test_canvas_takes_the_feedback_back(canvas: Canvas, tmp_path: Path) -> None:
    """By the names of the uploads: the first two numbers are the user's and the file's."""
    results, about = taken(tmp_path, UPLOADS, canvas.export())
    write_results(results, tmp_path / "out", ResultOptions(**about))
    with zipfile.ZipFile(tmp_path / "out" / "canvas" / f"{SLUG}-feedback.zip") as archive:
        ids = [[int(part) for part in name.split("_") if part.isdecimal()][:2]
               for name in archive.namelist()]  # fmt: skip
        assert sorted(ids) == [[id_, int(f"90{id_}")] for id_ in NAMES]
        (carla,) = (name for name in archive.namelist() if "_11_" in name)
        (page,) = (tmp_path / "out" / "feedback").glob(f"Carla Lee~*/{SLUG}.html")
        assert archive.read(carla) == page.read_bytes()


def test_columns_are_named_as_given() -> None:
    assert column_titles(["1=Week 1 = robots", "goal_seeking=B"]) == {
        "obstacle_avoidance": "Week 1 = robots",
        "goal_seeking": "B",
    }
    for wrong in ("1", "1=", "=x", "nothing=x"):
        with pytest.raises(InputError):
            column_titles([wrong])


# --- Moodle --------------------------------------------------------------------------------------

NAMED = {"71": "Ann Lee", "72": "Ann Lee", "73": "=Bob Ray", "74": "Cy Dee"}


@pytest.fixture
def assignment() -> MoodleAssignment:
    users = {"71": "ann", "72": "ann2", "73": "bob", "74": "cy"}
    return MoodleAssignment(users, 50.0, {"ann": (20.0, 1777000000)})


FOLDERS = tuple(f"{NAMED[id_]}_{id_}_assignsubmission_file/{AGENT}" for id_ in NAMED if id_ != "72")


def moodle_book(tmp_path: Path, *sheets: str) -> Book:
    results, about = taken(tmp_path, FOLDERS, *sheets)
    return book_of(results, **about)


def test_a_class_from_elsewhere_gets_its_only_worksheet_filled_in(
    tmp_path: Path, assignment: MoodleAssignment
) -> None:
    sheet = assignment.worksheet(NAMED)
    results, about = taken(tmp_path, [f"{name}/{AGENT}" for name in set(NAMED.values())], sheet)
    book = book_of(results, **about)
    assignment.load(worksheet_csv(book, TASK) or "")
    after = {user: grade for user, (grade, _) in assignment.grades.items()}
    assert after == {"ann": 20.0, "bob": 18.5, "cy": 30.0}  # two are called Ann Lee
    assert any("is not in 0.csv: Ann Lee" in remark for remark in book.remarks)
    assert worksheet_csv(book, TASK, alone=False) is None  # it may be another exercise's


@pytest.mark.parametrize(
    ("language", "with_sheet"),
    [("en", True), ("en", False), ("de", True), ("fr", True), ("es", True)],
)
def test_moodle_takes_its_worksheet_back(
    tmp_path: Path, assignment: MoodleAssignment, language: str, with_sheet: bool
) -> None:
    assignment.language = language
    sheets = [assignment.worksheet(NAMED, locked=("cy",))] if with_sheet else []
    book = moodle_book(tmp_path, *sheets)
    text = worksheet_csv(book, TASK)
    if not with_sheet:
        assignment.maximum, assignment.grades = 100.0, {}
    assignment.load(text or "")
    after = {user: grade for user, (grade, _) in assignment.grades.items()}
    if with_sheet:  # scaled to 50 points
        assert after == {"ann": 30.0, "bob": 18.5}
        assert any("can't be changed: Cy Dee" in remark for remark in book.remarks)
    else:
        assert after == {"ann": 60.0, "bob": 37.0, "cy": 60.0}
    assert assignment.skipped == []


@pytest.mark.parametrize("maximum", ["-2.00", "0.00", "-"])
def test_moodle_gets_no_points_for_a_scale(
    tmp_path: Path, assignment: MoodleAssignment, maximum: str
) -> None:
    book = moodle_book(tmp_path, assignment.worksheet(NAMED).replace("50.00", maximum))
    assert worksheet_csv(book, TASK) is None
    said = f"the assignment's maximum grade is '{maximum}', so Moodle grades it on a scale"
    assert any(said in remark for remark in book.remarks)


def test_moodle_takes_the_feedback_back(tmp_path: Path, assignment: MoodleAssignment) -> None:
    results, about = taken(tmp_path, FOLDERS, assignment.worksheet(NAMED))
    write_results(results, tmp_path / "out", ResultOptions(**about))
    archive = tmp_path / "out" / "moodle" / f"{SLUG}-feedback.zip"
    assignment.load_feedback(archive)
    assert assignment.skipped == []
    assert assignment.files.keys() == {"ann", "bob", "cy"}
    folder = tmp_path / "out" / "feedback" / "=Bob Ray"
    assert assignment.files["bob"] == {f"{SLUG}.html": (folder / f"{SLUG}.html").read_bytes()}


@pytest.mark.parametrize(
    ("system", "wanted"),
    [
        ("folder", {"canvas"}), ("canvas", {"canvas"}), ("moodle", {"moodle"}),
        ("gradescope", set()), ("github", set()),
    ],
)  # fmt: skip
def test_gradebooks_are_where_the_class_may_be_its_platforms(
    system: str, wanted: set[str], tmp_path: Path
) -> None:
    for each in ("folder", system):  # those of an earlier run are gone
        students = {"ann": StudentRow("ann", handed={SLUG: Handed(each, "ann", "1")})}
        write_results([graded("ann")], tmp_path, ResultOptions(students=students))
    there = {path.name for path in tmp_path.iterdir()}
    assert there & {"canvas", "moodle"} == wanted
