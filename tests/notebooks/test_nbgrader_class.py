"""Seven students through nbgrader's commands: the gradebook says what `course grade` says.

In all exercises, which takes long: `make notebooks` (`COURSE_NOTEBOOKS=full`).
"""

import copy
import itertools
import json
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from nbgrader_kit import (
    ALL,
    FULL,
    MadeOnce,
    autograded,
    cell_named,
    code,
    exercises_of,
    fill,
    grades,
    hand_in,
    make_course,
    nbgrader,
    released,
    solution,
    source_of,
    stored,
    total,
)

from grader.claims.claims import claims
from grader.claims.mutants import FIELD
from grader.course.exercises import Exercise, all_exercises
from grader.course.submission import find_submission
from grader.grading.grading import grade_submission
from grader.launchers import fork_server
from grader.nbgrader.cells import definition
from grader.nbgrader.points import points_of
from grader.notebook.build import all_notebooks, asked_by
from rclpy_virtual_time.link.hosts import ForkServer

pytestmark = [
    pytest.mark.long,
    pytest.mark.skipif(not FULL, reason="seven students in all exercises: make notebooks"),
]
NOTEBOOKS = [name for name in all_notebooks() if name != "quiz"]
STUDENTS = ("right", "wrong", "untouched", "gone", "broken", "odd", "tampering")
Files = dict[str, str]
Checks = dict[str, tuple[int, str]]  # points, outcome
Scores = dict[tuple[str, str], tuple[float, Checks]]  # by student and exercise
UNSURE = ("error", "inconclusive")  # the machine stalled, twice
SCORES = "scores.json"  # what `course grade` gives
CANARY = "canary"  # a cell that is executed writes it


def nodes(exercise: Exercise, student: str) -> Files:
    """Return what a student has written for an exercise."""
    right = {file: solution(exercise.slug, file) for file in exercise.files}
    skeleton = {file: (exercise.folder / file).read_text("utf-8") for file in exercise.files}
    match student:
        case "right" | "odd":
            return right
        case "wrong" | "tampering":
            mutants = [
                one
                for one in claims(exercise)
                if not one.lacks and any(not check.startswith(FIELD) for check in one.fails)
            ]
            return dict(mutants[len(mutants) // 3].files)
        case "untouched":
            return skeleton
        case "gone":
            return {}
        case "broken":
            return {file: f"{text}\nif True print('oops')\n" for file, text in right.items()}
    raise AssertionError(student)


def expected() -> Iterator[tuple[str, str, float, Checks]]:
    """Yield what `course grade` gives: student, exercise, score and each check."""
    for exercise in all_exercises():
        with fork_server(libraries=exercise.libraries) as forkserver:
            for student in STUDENTS:
                yield student, exercise.slug, *graded(exercise, student, forkserver)


def graded(exercise: Exercise, student: str, forkserver: ForkServer) -> tuple[float, Checks]:
    files = nodes(exercise, student)
    if not files:  # `course grade` refuses an empty folder
        return 0, dict.fromkeys(points_of(exercise.slug), (0, "skip"))
    with tempfile.TemporaryDirectory(prefix="course-test-") as name:
        for file, text in files.items():
            Path(name, file).write_text(text, "utf-8")
        first, *others = exercise.files
        submission = find_submission(Path(name), first, others)
        grading = grade_submission(exercise, submission, forkserver, file=first)
        checks = {check.id: (check.points, check.outcome) for check in grading.checks}
        return grading.score, checks


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
    make_course(folder, NOTEBOOKS)
    for notebook, student in itertools.product(NOTEBOOKS, STUDENTS):
        files: Files = {}
        for exercise in exercises_of(notebook):
            files |= nodes(exercise, student)
        given = released(folder, notebook)
        hand_in(folder, student, notebook, written(given, files, student))
    said = nbgrader(folder, "autograde", ALL, COURSE_CANARY=str(folder / CANARY))
    assert "[ERROR]" not in said, said
    (folder / SCORES).write_text(json.dumps(list(expected())), "utf-8")


@pytest.fixture(scope="module")
def course(made_once: MadeOnce) -> Path:
    return made_once("students", grade_all)


def test_the_gradebook_says_what_course_grade_says(course: Path) -> None:
    """Cell by cell, and in all; but for those that a stalled machine left for a person."""
    gradebook, rows = grades(course), json.loads((course / SCORES).read_text("utf-8"))
    scores: Scores = {(student, slug): rest for student, slug, *rest in rows}
    unsure: set[tuple[str, str]] = set()
    for notebook in NOTEBOOKS:
        wants = asked_by(stored(notebook))
        for student, (cell, want) in itertools.product(STUDENTS, wants.items()):
            all_of_it, known = scores[student, want.exercise]
            checks = [known[name] for name in want.checks]
            points, by_hand = gradebook[student, notebook, cell]
            lacking = any(outcome == "unavailable" for _, outcome in checks)
            if student == "gone":  # for a person: is it in another form somewhere?
                assert (points, by_hand) == (None, True), cell
                continue
            if any(outcome in UNSURE for _, outcome in checks) or (by_hand and not lacking):
                unsure.add((student, want.exercise))
                continue
            raw = sum(points for points, _ in known.values())
            share = all_of_it / raw if raw else 0  # what a cap leaves
            won = share * sum(points for points, _ in checks)
            assert (points or 0, by_hand) == (pytest.approx(won), lacking), (student, cell)
    for student, slug in scores.keys() - unsure:
        score, _ = scores[student, slug]
        assert total(gradebook, student, slug) == pytest.approx(score), (student, slug)
        if slug == "obstacle_avoidance":
            assert (0 < score < 100) == (student in ("wrong", "tampering"))
    assert len(unsure) <= len(scores) // 10


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
    for student, words in (
        ("gone", "expected a cell that begins with %%node obstacle_avoidance_agent.py in this"),
        ("broken", "SyntaxError"),
    ):
        cell = cell_named(autograded(course, student, "01_loop"), "obstacle_avoidance-wiring")
        assert words in cell.outputs[0].data["text/plain"]
