"""Gradebook files, read by the rules of the platforms that import them."""

from __future__ import annotations

import csv
import io
import json
import subprocess
import sys
import zipfile
from dataclasses import replace
from pathlib import Path

import pytest
from importers import Canvas, Moodle, MoodleAssignment
from made_results import book as book_of
from made_results import check, result

from grader.classroom.marks import tasks_of
from grader.classroom.results import ResultOptions, column_titles, write_results
from grader.classroom.row import ABSENT, StoredResult
from grader.errors import InputError
from grader.lms.book import Book, Handed, StudentRow
from grader.lms.canvas import canvas_csv
from grader.lms.moodle import grades_csv, worksheet_csv
from grader.lms.people import Person, Roster
from grader.lms.sheets import read_roster
from grader.nbgrader.class_scores import write_scores

SLUG = "obstacle_avoidance"
TASK = replace(tasks_of([result("ann")])[0], folder=SLUG)


def graded(student: str, points: int = 60) -> StoredResult:
    return result(student, check("a", "pass", points), check("b", "fail", 100 - points))


def absent(student: str) -> StoredResult:
    return replace(result(student), state=ABSENT)


def row(roster: Roster, system: str, student: str, name: str, id_: str) -> StudentRow:
    """What intake makes of an entry of a download."""
    person = roster.find(system, name, id_)
    handed = {SLUG: Handed(system, name, id_)}
    if person is None:
        return StudentRow(student, handed=handed)
    return StudentRow(
        student, person.label, person.section, dict(person.ids),
        tuple(sorted(person.participants)), handed,
    )  # fmt: skip


@pytest.fixture
def canvas() -> Canvas:
    return Canvas(
        users={
            11: ("Lee, Carla", "clee"), 12: ("Peters, Dan", "@dan"), 13: ("=1+1", "=x"),
            14: ("Lee, Carla", "clee2"), 15: ("Excused, Eve", "eve"), 16: ("Un, Signed", "un"),
            17: ("Not, Here", "not"),
        },
        assignments={71: ("Week 1: Obstacle avoidance", "100"), 72: ("Goal seeking", "10")},
        scores={(11, 71): "55", (14, 71): "80", (15, 71): "EX", (17, 71): "30", (11, 72): "9"},
        unassigned={(16, 71)},
    )  # fmt: skip


NAMES = {
    11: "leecarla", 12: "petersdan", 13: "11", 14: "leecarla", 15: "excusedeve", 16: "unsigned",
}  # fmt: skip


def canvas_book(canvas: Canvas, tmp_path: Path, **options: object) -> Book:
    (tmp_path / "gradebook.csv").write_text(canvas.export())
    roster = read_roster([tmp_path / "gradebook.csv"])
    known = {f"{name}_{id_}": (name, str(id_)) for id_, name in NAMES.items()}
    students = {s: row(roster, "canvas", s, *about) for s, about in known.items()}
    results = [graded(student) for student in students]
    results[3] = absent("leecarla_14")
    titles = column_titles(options.get("columns", ()))  # type: ignore[arg-type]
    return book_of(results, students=students, roster=roster, columns=titles)


def test_canvas_changes_what_was_graded_and_nothing_else(canvas: Canvas, tmp_path: Path) -> None:
    book = canvas_book(canvas, tmp_path)
    task = TASK
    text = canvas_csv(book, task)
    assert text is not None
    canvas.load(text)
    assert canvas.changes == {(11, 71): "60", (12, 71): "60", (13, 71): "60"}
    assert not (canvas.new_users or canvas.new_assignments or canvas.new_points)
    assert any("excused in Canvas: excusedeve_15" in remark for remark in book.remarks)
    assert any("not assigned to them in Canvas: unsigned_16" in r for r in book.remarks)
    cells = list(csv.reader(io.StringIO(text)))
    assert cells[0] == [
        "Student", "ID", "SIS User ID", "SIS Login ID", "Section",
        "Week 1: Obstacle avoidance (71)",
    ]  # fmt: skip
    assert [line[0] for line in cells[1:]] == ["'=1+1", "Lee, Carla", "Peters, Dan"]
    assert [line[3] for line in cells[1:]] == ["=x", "clee", "@dan"]  # ids stay as they are


def test_canvas_points_are_scaled_to_the_column(canvas: Canvas, tmp_path: Path) -> None:
    book = canvas_book(canvas, tmp_path, columns=["1=Goal seeking"])
    task = TASK
    canvas.load(canvas_csv(book, task) or "")
    assert canvas.changes[11, 72] == canvas.changes[12, 72] == "6"
    assert not canvas.new_points
    assert any("scaled from 100 to the 10" in remark for remark in book.remarks)


def test_canvas_makes_an_assignment_it_has_not(canvas: Canvas, tmp_path: Path) -> None:
    canvas.assignments = {72: ("Goal seeking", "10")}
    book = canvas_book(canvas, tmp_path)
    task = TASK
    canvas.load(canvas_csv(book, task) or "")
    assert canvas.new_assignments == ["Obstacle avoidance"]
    assert canvas.new_points == {-1: "100"}
    assert {user for user, _ in canvas.changes} == {11, 12, 13, 15, 16}
    assert any("--column '1=TITLE'" in remark for remark in book.remarks)


def test_canvas_ids_of_the_download_do_without_a_roster(canvas: Canvas) -> None:
    students = {
        f"{name}_{id_}": StudentRow(
            f"{name}_{id_}", handed={SLUG: Handed("canvas", name, str(id_))}
        )
        for id_, name in NAMES.items()
    }
    book = book_of([graded(student) for student in students], students=students)
    canvas.assignments = {71: ("Obstacle avoidance", "100")}
    canvas.load(canvas_csv(book, TASK) or "")
    assert {user for user, _ in canvas.changes} == {11, 12, 13, 14, 15}
    assert not (canvas.new_users or canvas.new_assignments or canvas.new_points)


def test_columns_are_named_as_told() -> None:
    assert column_titles(["1=Week 1 = robots", "goal_seeking=B"]) == {
        "obstacle_avoidance": "Week 1 = robots",
        "goal_seeking": "B",
    }
    for wrong in ("1", "1=", "=x", "nothing=x"):
        with pytest.raises(InputError):
            column_titles([wrong])


# --- Moodle --------------------------------------------------------------------------------------

GRADES = """First name,Last name,ID number,Email address,"Assignment: Obstacle avoidance (Real)",Last downloaded from this course
Ann,Lee,4001,ann@uni.edu,50.00,1777900000
Ann,Lee,4002,ann2@uni.edu,-,1777900000
=Bob,Ray,4003,bob@uni.edu,-,1777900000
Cy,Dee,,cy@uni.edu,-,1777900000
"""  # noqa: E501
NAMED = {"71": "Ann Lee", "72": "Ann Lee", "73": "=Bob Ray", "74": "Cy Dee"}


@pytest.fixture
def assignment() -> MoodleAssignment:
    users = {"71": "ann", "72": "ann2", "73": "bob", "74": "cy"}
    return MoodleAssignment(users, 50.0, {"ann": (20.0, 1777000000)})


def moodle_book(tmp_path: Path, *sheets: str) -> Book:
    files = []
    for number, text in enumerate(sheets):
        files.append(tmp_path / f"{number}.csv")
        files[-1].write_text(text)
    roster = read_roster(files)
    ids = {"a1": "71", "a2": "72", "bob": "73", "cy": "74"}
    students = {s: row(roster, "moodle", s, NAMED[id_], id_) for s, id_ in ids.items()}
    results = [graded("a1"), absent("a2"), graded("bob", 37), graded("cy")]
    return book_of(results, students=students, roster=roster)


def test_moodle_imports_grades_of_those_who_have_some(
    tmp_path: Path, assignment: MoodleAssignment
) -> None:
    book = moodle_book(tmp_path, GRADES, assignment.worksheet(NAMED))
    text = grades_csv(book, TASK)
    moodle = Moodle({"ann@uni.edu": "ann", "bob@uni.edu": "bob", "cy@uni.edu": "cy"})
    moodle.load(text or "")
    assert moodle.grades == {"ann": 30.0, "bob": 18.5, "cy": 30.0}  # of 50, says the worksheet
    assert not any("is out of 100 points" in remark for remark in book.remarks)
    assert "Assignment: Obstacle avoidance (Real)" in (text or "")
    moodle.graded = {"bob": 1777900001}
    with pytest.raises(AssertionError, match="graded after the download"):
        moodle.load(text or "")


def test_two_of_one_name_are_not_guessed(tmp_path: Path) -> None:
    book = moodle_book(tmp_path, GRADES)  # without the worksheet nothing tells the two apart
    text = grades_csv(book, TASK) or ""
    assert "ann" not in text
    assert any("has no Email address in the roster: a1" in remark for remark in book.remarks)
    assert ",60," in text and any("is out of 100 points" in remark for remark in book.remarks)


def test_two_with_one_number_are_in_no_import() -> None:
    numbers = {"bob": "711", "cy": "711", "ann": "712"}
    people = tuple(Person(name, ids={"idnumber": number}) for name, number in numbers.items())
    students = {name: StudentRow(name, name, ids={"idnumber": numbers[name]}) for name in numbers}
    results = [graded("bob"), graded("cy", 40), graded("ann", 50)]
    book = book_of(results, students=students, roster=Roster(people))
    text = grades_csv(book, TASK) or ""
    assert "711" not in text and "712,50" in text
    assert any("shares their ID number: bob, cy" in remark for remark in book.remarks)


@pytest.mark.parametrize("with_sheet", [True, False])
def test_moodle_takes_its_worksheet_back(
    tmp_path: Path, assignment: MoodleAssignment, with_sheet: bool
) -> None:
    sheets = [assignment.worksheet(NAMED, locked=("cy",))] if with_sheet else []
    book = moodle_book(tmp_path, *sheets)
    text = worksheet_csv(book, TASK)
    if not with_sheet:
        assignment.maximum, assignment.grades = 100.0, {}
    assignment.load(text or "")
    after = {user: grade for user, (grade, _) in assignment.grades.items()}
    if with_sheet:  # scaled to 50 points
        assert after == {"ann": 30.0, "bob": 18.5}
        assert any("can't be changed: cy" in remark for remark in book.remarks)
    else:
        assert after == {"ann": 60.0, "bob": 37.0, "cy": 60.0}
    assert assignment.skipped == []


@pytest.mark.parametrize("maximum", ["-2.00", "0.00", "-"])
def test_moodle_gets_no_points_for_a_scale(
    tmp_path: Path, assignment: MoodleAssignment, maximum: str
) -> None:
    book = moodle_book(tmp_path, GRADES, assignment.worksheet(NAMED).replace("50.00", maximum))
    task = TASK
    assert worksheet_csv(book, task) is None
    assert grades_csv(book, task) is None
    said = f"the assignment's maximum grade is '{maximum}', so Moodle grades it on a scale"
    assert sum(said in remark for remark in book.remarks) == 2


def test_a_locked_grade_is_in_no_import(tmp_path: Path, assignment: MoodleAssignment) -> None:
    book = moodle_book(tmp_path, GRADES, assignment.worksheet(NAMED, locked=("cy",)))
    moodle = Moodle({"4001": "ann", "4003": "bob"})
    moodle.load(grades_csv(book, TASK) or "")
    assert moodle.grades == {"ann": 30.0, "bob": 18.5}
    assert any("has a grade that can't be changed: cy" in remark for remark in book.remarks)


def test_moodle_takes_the_feedback_back(tmp_path: Path, assignment: MoodleAssignment) -> None:
    book = moodle_book(tmp_path, assignment.worksheet(NAMED))
    options = ResultOptions(students=book.students, roster=book.roster)
    results = [graded("a1"), absent("a2"), graded("bob", 37), graded("cy")]
    write_results(results, tmp_path / "out", options)
    archive = tmp_path / "out" / "moodle" / f"{SLUG}-feedback.zip"
    assignment.load_feedback(archive)
    assert assignment.skipped == []
    assert assignment.files.keys() == {"ann", "bob", "cy"}
    page = (tmp_path / "out" / "feedback" / "bob" / f"{SLUG}.html").read_bytes()
    assert assignment.files["bob"] == {f"{SLUG}.html": page}
    before = archive.read_bytes()
    write_results(results, tmp_path / "out", options)
    assert archive.read_bytes() == before


# --- nbgrader ------------------------------------------------------------------------------------


def test_nbgrader_has_a_row_for_each_score(tmp_path: Path) -> None:
    students = {
        "ann+x": StudentRow(
            "ann+x", handed={SLUG: Handed("nbgrader", "ann+x", "ann+x", time="2026-05-04")}
        )
    }
    write_results([graded("ann+x"), absent("bob")], tmp_path, ResultOptions(students=students))
    (line,) = csv.DictReader((tmp_path / "nbgrader.csv").read_text("utf-8").splitlines())
    assert (line["assignment"], line["student_id"], line["timestamp"]) == (
        SLUG, "ann+x", "2026-05-04",
    )  # fmt: skip
    assert (line["score"], line["max_score"]) == ("60", "100")


@pytest.mark.long  # nbgrader takes a while to import
def test_nbgraders_own_gradebook(tmp_path: Path) -> None:
    api = pytest.importorskip("nbgrader.api")
    db = tmp_path / "gradebook.db"
    students = {"ann": StudentRow("ann", "Ann Lee", ids={"login": "alee", "email": "a@uni.edu"})}
    write_scores(db, [])  # makes it
    with api.Gradebook(f"sqlite:///{db}") as book:
        book.add_student("alee", last_name="Kept")
        book.add_assignment("week1")
    options = ResultOptions(students=students, nbgrader=db)
    for points in (60, 70):
        done = write_results([graded("ann", points), absent("bob")], tmp_path / "out", options)
        assert done.missing == []
    with api.Gradebook(f"sqlite:///{db}") as book:
        found = book.find_submission(SLUG, "alee")
        assert (found.score, found.max_score) == (70.0, 100.0)
        assert (found.student.first_name, found.student.last_name) == ("Ann", "Kept")
        assert [s.id for s in book.students] == ["alee"]
        assert {a.name for a in book.assignments} == {"week1", SLUG}
        book.add_notebook("01_loop", SLUG)
    (missing,) = write_results([graded("ann")], tmp_path / "out", options).missing
    assert "give another file to --nbgrader" in str(missing)


# --- Gradescope ----------------------------------------------------------------------------------


def test_gradescope_hands_out_what_was_graded_here(tmp_path: Path) -> None:
    handed = {"ann": "submission_101", "bob": "submission_101", "cy": "submission_103"}
    students = {
        s: StudentRow(s, handed={SLUG: Handed("gradescope", s, entry=e)}) for s, e in handed.items()
    }
    held = replace(graded("cy"), state="held")
    options = ResultOptions(students=students)
    done = write_results([graded("ann"), graded("bob"), held], tmp_path / "out", options)
    assert done.missing == []
    root = tmp_path / "autograder"
    with zipfile.ZipFile(tmp_path / "out" / "gradescope" / "autograder.zip") as archive:
        archive.extractall(root / "source")
        modes = {info.filename: info.external_attr >> 16 for info in archive.infolist()}
    assert modes["run_autograder"] & modes["setup.sh"] & 0o111
    assert sorted(path.name for path in (root / "source" / "graded").iterdir()) == ["101.json"]

    def run(submission: int) -> subprocess.CompletedProcess[str]:
        (root / "submission_metadata.json").write_text(json.dumps({"id": submission}))
        return subprocess.run(
            [sys.executable, str(root / "source" / "run_autograder")],
            env={"AUTOGRADER_ROOT": str(root)}, text=True, capture_output=True, check=False,
        )  # fmt: skip

    assert run(103).returncode == 1
    assert not (root / "results").exists()
    assert run(101).returncode == 0
    assert json.loads((root / "results" / "results.json").read_text())["score"] == 60.0


def test_results_for_gradescope_are_where_the_class_may_be_its(tmp_path: Path) -> None:
    def written(system: str) -> bool:
        students = {"ann": StudentRow("ann", handed={SLUG: Handed(system, "ann", "1")})}
        write_results([graded("ann")], tmp_path, ResultOptions(students=students))
        return (tmp_path / "gradescope").exists()

    assert written("folder")
    assert not written("canvas")  # one of an earlier run is gone, too
    assert written("gradescope")
    assert not written("moodle")
