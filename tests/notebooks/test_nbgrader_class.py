"""Twelve students through nbgrader's commands: the gradebook says what `course grade` says.

In all nine exercises, which takes long: `make notebooks` (`COURSE_NOTEBOOKS=full`).
"""

import copy
import csv
import itertools
import json
import re
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import nbformat
import pytest
from nbgrader_kit import (
    ALL,
    FULL,
    Grades,
    MadeOnce,
    autograded,
    cell_named,
    code,
    fill,
    grades,
    hand_in,
    make_course,
    nbgrader,
    released,
    solution,
    source_of,
    total,
)

from grader.authoring.claims import Claim, claims
from grader.course.exercises import Exercise, find_exercise
from grader.course.skeletons import strip_solution
from grader.course.submission import find_submission
from grader.grading.grading import grade_submission
from grader.link.hosts import ForkServer
from grader.nbgrader.cells import definition
from grader.nbgrader.points import points_of
from grader.notebook.build import all_notebooks, asked_by
from grader.notebook.build import source_of as source_path
from sim.messages import EPOCH_NS

pytestmark = [
    pytest.mark.long,
    pytest.mark.skipif(not FULL, reason="twelve students in nine exercises: make notebooks"),
]
EXERCISES = {
    "01_loop": ["1"], "02_trained_model": ["2", "7"], "03_goal": ["3"], "04_memory": ["4"],
    "05_real_time": ["5", "6", "9"], "06_formats": ["8"],
}  # fmt: skip
STUDENTS = [
    "right", "variant", "wrong_1", "wrong_2", "wrong_3", "wrong_4",
    "half", "untouched", "gone", "broken", "odd", "tampering",
]  # fmt: skip
HANDED_IN = dict.fromkeys(EXERCISES, STUDENTS)
Files = dict[str, str]
Checks = dict[str, tuple[int, str]]  # points, outcome
Scores = dict[tuple[str, str], Checks]  # by student and exercise
UNSURE = ("error", "inconclusive")  # the machine stalled, twice
SCORES = "scores.json"  # what `course grade` gives
CANARY = "canary"  # a cell that is executed writes it


def nodes(exercise: Exercise, student: str) -> Files:
    """Return what a student has written for an exercise."""
    right = {file: solution(exercise.slug, file) for file in exercise.files}
    skeleton = {file: (exercise.folder / file).read_text("utf-8") for file in exercise.files}
    match student.partition("_"):
        case ("right" | "odd", _, _):
            return right
        case ("variant", _, _):
            return next((dict(c.files) for c in found(exercise, "variant")), right)
        case ("wrong", _, number):
            mutants = found(exercise, "mutant")
            return dict(mutants[int(number) * len(mutants) // 5].files)
        case ("half" | "tampering", _, _):
            return {**right, exercise.files[0]: half_finished(exercise)}
        case ("untouched", _, _):
            return skeleton
        case ("gone", _, _):
            return {}
        case ("broken", _, _):
            return {file: f"{text}\nif True print('oops')\n" for file, text in right.items()}
    raise AssertionError(student)


def found(exercise: Exercise, kind: str) -> list[Claim]:
    return [claim for claim in claims(exercise) if claim.kind == kind and not claim.lacks]


def half_finished(exercise: Exercise) -> str:
    """Return the first file with its last block still to be done."""
    name = exercise.files[0]
    text = (exercise.solutions / name).read_text("utf-8")
    head, mark, tail = text.rpartition("### BEGIN SOLUTION")
    indent = head[len(head.rstrip(" ")) :]
    last = strip_solution(f"{indent}{mark}{tail}")
    lines = solution(exercise.slug, name)
    done = head.count("\n") - len(re.findall(r"(?m)^\s*### ", head))
    done -= sum(block.count("\n") - 1 for block in
                re.findall(r"### SKELETON(.*?)### END", head, re.DOTALL))  # fmt: skip
    return "\n".join(lines.split("\n")[:done]) + "\n" + last


def expected() -> Iterator[tuple[str, str, Checks]]:
    """Yield what `course grade` gives: student, exercise, points and outcome of each check."""
    for notebook, students in HANDED_IN.items():
        for exercise in map(find_exercise, EXERCISES[notebook]):
            with ForkServer(EPOCH_NS, libraries=exercise.libraries) as forkserver:
                for student in students:
                    yield student, exercise.slug, graded(exercise, student, forkserver)


def graded(exercise: Exercise, student: str, forkserver: ForkServer) -> Checks:
    files = nodes(exercise, student)
    if not files:  # `course grade` refuses an empty folder
        return dict.fromkeys(points_of(exercise.slug), (0, "skip"))
    with tempfile.TemporaryDirectory(prefix="course-test-") as name:
        for file, text in files.items():
            Path(name, file).write_text(text, "utf-8")
        first, *others = exercise.files
        submission = find_submission(Path(name), first, others)
        grading = grade_submission(exercise, submission, forkserver, file=first)
        return {check.id: (check.points, check.outcome) for check in grading.checks}


def written(notebook: dict[str, Any], files: Files, student: str) -> dict[str, Any]:
    """Return the notebook that a student hands in."""
    notebook = fill(copy.deepcopy(notebook), files)
    if student == "gone":
        notebook["cells"] = [c for c in notebook["cells"] if definition(source_of(c)) is None]
    elif student == "odd":
        notebook["cells"] = [oddly(cell) for cell in reversed(notebook["cells"])]
    elif student == "tampering":
        tamper(notebook)
    return notebook


def oddly(cell: dict[str, Any]) -> dict[str, Any]:
    made = definition(source_of(cell)) if cell["cell_type"] == "code" else None
    if made is not None:
        text = f"\n# mine\n%%node   {made.file} \n{made.text}".replace("\n", "\r\n")
        cell = {**cell, "source": f"\ufeff{text}", "metadata": {"tags": [1, None]}}
    return cell


def tamper(notebook: dict[str, Any]) -> None:
    """Do everything to the tests that can be done from within a notebook."""
    lie = [
        {"output_type": "display_data", "data": {"text/plain": "100 of 100"}, "metadata": {}},
        {"output_type": "execute_result", "data": {"text/plain": "1000.0"}, "metadata": {},
         "execution_count": 1},
    ]  # fmt: skip
    for number, cell in enumerate(list(notebook["cells"])):
        about = cell["metadata"].get("nbgrader", {})
        if not about.get("grade"):
            continue
        about |= {"points": 1000, "checksum": "0" * 32, "locked": False}
        cell["outputs"] = lie
        match number % 4:
            case 0:
                cell["source"] = "'all of them pass'"
            case 1:
                cell["cell_type"] = "markdown"
            case 2:
                about["grade_id"] = "something-else"
            case _:
                notebook["cells"].append(copy.deepcopy(cell))
    evil = "\n".join(
        [
            "import grader.notebook, builtins, os, sys",
            "grader.notebook.check = builtins.check = check = lambda *a, **k: 1000.0",
            "get_ipython().input_transformers_cleanup.append(lambda lines: ['1000.0'])",
            "get_ipython().showtraceback = lambda *a, **k: None",
            "open(os.environ.get('COURSE_CANARY', '/nowhere/x'), 'w').write('executed')",
            "os.kill(os.getppid(), 9)",
        ]
    )
    notebook["cells"].insert(0, code(evil, metadata={"nbgrader": {"grade": True, "points": 99}}))
    notebook["cells"].append(code("%%node ../../grader/grading.py\nATTEMPTS = 0"))


def grade_all(folder: Path) -> None:
    """Make the course, with everything handed in and graded, and the scores beside it."""
    make_course(folder, list(HANDED_IN))
    for notebook, students in HANDED_IN.items():
        given = released(folder, notebook)
        for student in students:
            files: Files = {}
            for number in EXERCISES[notebook]:
                files |= nodes(find_exercise(number), student)
            hand_in(folder, student, notebook, written(given, files, student))
    said = nbgrader(folder, "autograde", ALL, COURSE_CANARY=str(folder / CANARY))
    assert "[ERROR]" not in said, said
    (folder / SCORES).write_text(json.dumps(list(expected())), "utf-8")


@pytest.fixture(scope="module")
def course(made_once: MadeOnce) -> Path:
    return made_once("students", grade_all)


@pytest.fixture(scope="module")
def gradebook(course: Path) -> Grades:
    return grades(course)


@pytest.fixture(scope="module")
def scores(course: Path) -> Scores:
    rows = json.loads((course / SCORES).read_text("utf-8"))
    return {
        (student, slug): {name: (points, outcome) for name, (points, outcome) in checks.items()}
        for student, slug, checks in rows
    }


def test_the_gradebook_says_what_course_grade_says(
    course: Path, gradebook: Grades, scores: Scores
) -> None:
    """Cell by cell, and in all; but for those that a stalled machine left for a person."""
    unsure: set[tuple[str, str]] = set()
    for notebook, students in HANDED_IN.items():
        wants = asked_by(nbformat.read(source_path(notebook), as_version=4))
        for student, (cell, want) in itertools.product(students, wants.items()):
            checks = [scores[student, want.exercise][name] for name in want.checks]
            score, by_hand = gradebook[student, notebook, cell]
            lacking = any(outcome == "unavailable" for _, outcome in checks)
            if any(outcome in UNSURE for _, outcome in checks) or (by_hand and not lacking):
                unsure.add((student, want.exercise))
                continue
            assert (score or 0, by_hand) == (sum(p for p, _ in checks), lacking), (student, cell)
    for student, slug in scores.keys() - unsure:
        points = sum(points for points, _ in scores[student, slug].values())
        assert total(gradebook, student, slug) == points, (student, slug)
    assert len(unsure) <= len(scores) // 10


def test_the_students_are_as_different_as_they_should_be(scores: Scores) -> None:
    first = {
        student: sum(points for points, _ in checks.values())
        for (student, slug), checks in scores.items()
        if slug == "obstacle_avoidance"
    }

    assert [first[name] for name in ("right", "variant", "odd")] == [100, 100, 100]
    assert [first[name] for name in ("untouched", "gone", "broken")] == [0, 0, 0]
    assert 0 <= first["half"] == first["tampering"] < 100
    assert len({first[f"wrong_{n}"] for n in range(1, 5)} - {0, 100}) >= 2


def test_what_was_not_handed_in_is_worth_nothing(gradebook: Grades) -> None:
    lacking = [
        score
        for (student, notebook, _), (score, _) in gradebook.items()
        if student not in HANDED_IN[notebook]
    ]

    assert set(lacking) <= {0.0}


def test_no_cell_of_a_student_was_executed(course: Path) -> None:
    assert not (course / CANARY).exists()


def test_the_judges_table_stands_in_the_test_cells(course: Path) -> None:
    notebook = autograded(course, "tampering", "01_loop")
    tests = [c for c in notebook.cells if c.metadata.get("nbgrader", {}).get("grade")]

    assert len(tests) == 5
    for cell in tests:
        (output,) = cell.outputs
        assert "1000" not in output.data["text/plain"]
        assert "points" in output.data["text/plain"]
    others = [c for c in notebook.cells if c.cell_type == "code" and c not in tests]
    assert not any(cell.outputs for cell in others)
    gone = cell_named(autograded(course, "gone", "01_loop"), "obstacle_avoidance-wiring")
    expected = "expected a cell that begins with %%node obstacle_avoidance_agent.py in this"
    assert expected in gone.outputs[0].data["text/plain"]


def test_a_syntax_error_is_told_as_course_grade_tells_it(course: Path) -> None:
    cell = cell_named(autograded(course, "broken", "01_loop"), "obstacle_avoidance-wiring")

    assert "SyntaxError" in cell.outputs[0].data["text/plain"]


def test_feedback_and_export(course: Path, gradebook: Grades) -> None:
    nbgrader(course, "generate_feedback", "01_loop", "--student", "wrong_1")
    nbgrader(course, "export")

    page = (course / "feedback" / "wrong_1" / "01_loop" / "01_loop.html").read_text("utf-8")
    points = total(gradebook, "wrong_1", "obstacle_avoidance")
    assert f"(Score: {points:g}" in page.replace(".0 /", " /")
    assert "✗ FAIL" in page
    assert "expected: " in page
    assert not re.search(r"""(src|srcset)=["']?\s*(https?:)?//|mathjax/""", page)
    with (course / "grades.csv").open(newline="") as file:
        rows = {row["student_id"]: float(row["score"]) for row in csv.DictReader(file)}
    for student in STUDENTS:
        ours = sum(score or 0 for (who, _, _), (score, _) in gradebook.items() if who == student)
        assert rows[student] == ours


def test_all_notebooks_are_here() -> None:
    assert [*EXERCISES, "07_quiz"] == all_notebooks()
