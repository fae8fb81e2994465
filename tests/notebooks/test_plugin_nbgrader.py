"""The plug-in in nbgrader's commands: what is refused, what a person has to look at, what stays."""

import csv
import json
import os
import shutil
from pathlib import Path
from typing import Any

import pytest
from nbformat import v4
from nbgrader.converters.base import NbGraderException
from nbgrader_kit import (
    ALL,
    MadeOnce,
    autograded,
    cell_named,
    fill,
    grades,
    hand_in,
    make_course,
    mark_by_hand,
    marks_by_hand,
    nbgrader,
    released,
    solution,
    total,
)
from traitlets.config import Config

from grader.course.exercises import find_exercise
from grader.course.students import student_key
from grader.errors import GraderError, InputError
from grader.launchers import ForkServerPool
from grader.nbgrader import autograde, configure, judge
from grader.nbgrader.autograde import CourseExporter
from grader.nbgrader.gradebook import Place
from grader.nbgrader.judge import Verdict
from grader.nbgrader.release import LeaveSkeletons

pytestmark = pytest.mark.long
SLUG = "obstacle_avoidance"
FILE = "obstacle_avoidance_agent.py"
EVIL = "Because. <script>steal()</script> [x](javascript:steal())"
SWITCHES = """
import os, sys
from grader.errors import GraderError
from grader.course.exercises import find_exercise
from grader.grading import handed_in
from rclpy_virtual_time import ForkServer

if os.environ.get("TEST_OPEN"):
    said = "nothing is kept apart here; say so with --trust"
    ForkServer.foreign_code = said
if os.environ.get("TEST_FAULT"):
    def fault(*arguments, **more):
        raise GraderError("no host for the node")
    handed_in.grade_submission = fault
c.JudgeNodes.trust = bool(os.environ.get("TEST_TRUST"))
"""


def answered(course: Path, *answers: str) -> dict[str, Any]:
    notebook = released(course, "quiz")
    for number, answer in enumerate(answers, start=1):
        cell_named(notebook, f"quiz-{number}")["source"] = answer
    return notebook


def solved(course: Path) -> dict[str, Any]:
    return fill(released(course, "01_loop"), {FILE: solution(SLUG, FILE)})


def grade_one(course: Path) -> None:
    """Grade one student on bad days: a machine too open, then a grader that fails."""
    make_course(course, ["01_loop", "quiz"], SWITCHES)
    hand_in(course, "unlucky", "01_loop", solved(course))
    first = nbgrader(course, "autograde", ALL, ok=False, TEST_OPEN="1")
    assert not (course / "autograded").exists()
    assert not grades(course)
    then = {"TEST_OPEN": "1", "TEST_TRUST": "1", "TEST_FAULT": "1"}
    second = nbgrader(course, "autograde", ALL, **then)
    (course / "said.json").write_text(json.dumps([first, second]), "utf-8")


@pytest.fixture(scope="module")
def bad_days(made_once: MadeOnce) -> Path:
    return made_once("bad-days", grade_one)


@pytest.fixture
def course(bad_days: Path, tmp_path: Path) -> Path:
    """A copy, to go on from there."""
    return Path(shutil.copytree(bad_days, tmp_path / "course"))


def test_without_isolation_nothing_is_graded_and_a_fault_is_for_a_person(bad_days: Path) -> None:
    first, second = json.loads((bad_days / "said.json").read_text("utf-8"))
    marks = {mark for (_, notebook, _), mark in grades(bad_days).items() if notebook == "01_loop"}
    cell = cell_named(autograded(bad_days, "unlucky", "01_loop"), f"{SLUG}-wiring")
    said = "Nothing was graded: nothing is kept apart here; say so with c.JudgeNodes.trust"
    assert said in first
    assert "Traceback" not in first
    assert marks == {(None, True)}  # trusted then, by a grader that fails
    assert "could not be judged: no host for the node" in cell.outputs[0].data["text/plain"]
    assert "no host for the node" in second


def test_a_class_with_unreadable_notebooks_is_graded(course: Path, tmp_path: Path) -> None:
    """One run: nothing that one hands in keeps another from being graded."""
    hand_in_oddities(course, tmp_path)
    with_a_person = ("unlucky", "01_loop", f"{SLUG}-wiring")
    mark_by_hand(course, with_a_person, 7.0)
    said = nbgrader(course, "autograde", ALL, "--force")
    assert "Traceback" not in said
    found = grades(course)
    assert found[with_a_person] == (15.0, True)
    assert found["unlucky", "01_loop", f"{SLUG}-clear_zone"] == (30.0, False)
    assert marks_by_hand(course) == [7.0]
    for student in ("a_garbage", "b_link", "c_bomb"):
        marks = {mark for (who, nb, _), mark in found.items() if (who, nb) == (student, "01_loop")}
        assert marks == {(None, True)}, student
        notebook = autograded(course, student, "01_loop")
        assert notebook.cells[0].source.startswith("The submitted notebook could not be read: ")
        assert "front_distance" not in json.dumps(notebook)
    for student in ("d_bare", "g_huge", "h_editor", "i_writes"):
        assert total(found, student, SLUG) == 100
    size = (course / "autograded" / "g_huge" / "01_loop" / "01_loop.ipynb").stat().st_size
    assert size < 200_000
    quiz = [found["e_quiz", "quiz", f"quiz-{n}"] for n in range(1, 6)]
    assert quiz == [(None, True)] * 2 + [(0.0, False)] * 3
    assert {found["f_gone", "quiz", f"quiz-{n}"] for n in range(1, 6)} == {(None, True)}
    nbgrader(course, "generate_feedback", "quiz", "--student", "e_quiz")
    feedback = course / "feedback" / "e_quiz" / "quiz" / "quiz.html"
    page = feedback.read_text("utf-8")
    assert "Because." in page
    assert "steal()" not in page
    assert "quiz (Score: not judged yet / 15.0)" in page
    assert page.count("Score: not judged yet / 3.0") == 4  # of two answers, above and beside
    assert exported(course, "e_quiz", "quiz") == ("", "", "", "6")
    assert exported(course, "a_garbage", "01_loop") == ("", "", "", "100")
    assert exported(course, "h_editor", "01_loop") == ("100.0", "0.0", "100.0", "0")
    for number in (1, 2):
        mark_by_hand(course, ("e_quiz", "quiz", f"quiz-{number}"), number)
    nbgrader(course, "generate_feedback", "quiz", "--student", "e_quiz")
    assert "quiz (Score: 3.0 / 15.0)" in feedback.read_text("utf-8")
    assert exported(course, "e_quiz", "quiz") == ("3.0", "0.0", "3.0", "0")


SCORES = ("raw_score", "late_submission_penalty", "score", "not_judged")


def exported(course: Path, student: str, assignment: str) -> tuple[str, ...]:
    nbgrader(course, "export")
    with (course / "grades.csv").open(newline="") as file:
        rows = {(row["student_id"], row["assignment"]): row for row in csv.DictReader(file)}
    return tuple(rows[student, assignment][name] for name in SCORES)


def hand_in_oddities(course: Path, elsewhere: Path) -> None:
    secret = elsewhere / "secret.ipynb"
    secret.write_text(json.dumps(solved(course)), "utf-8")
    hand_in(course, "a_garbage", "01_loop", "this is no JSON")
    link = hand_in(course, "b_link", "01_loop", "")
    link.unlink()
    link.symlink_to(secret)
    hand_in(course, "c_bomb", "01_loop", '{"cells": ' + "[" * 200_000)
    bare = solved(course)
    for cell in bare["cells"]:
        cell["metadata"] = {}
        cell.pop("id")
    del bare["metadata"], bare["nbformat"]
    hand_in(course, "d_bare", "01_loop", bare)
    hand_in(course, "e_quiz", "quiz", answered(course, "Because.", EVIL))
    gone = answered(course)
    gone["cells"] = [c for c in gone["cells"] if "nbgrader" not in c["metadata"]]
    hand_in(course, "f_gone", "quiz", gone)
    huge = solved(course)
    noise = {"output_type": "stream", "name": "stderr", "text": "x" * 8_000_000}
    huge["cells"][1]["outputs"] = [noise]
    hand_in(course, "g_huge", "01_loop", huge)
    beside = hand_in(course, "h_editor", "01_loop", released(course, "01_loop"))
    (beside.parent / "helper.py").touch()
    alone = f"import os, helper\nassert set(os.listdir()) <= {{'.home', 'helper.py', '{FILE}'}}\n"
    (beside.parent / FILE).write_text(alone + solution(SLUG, FILE))
    hand_in(course, "i_writes", "01_loop", json.loads(
        json.dumps(solved(course)).replace(f"%%node {FILE}", f"%%writefile {FILE}")))  # fmt: skip


def test_every_student_has_worlds_of_their_own(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    seeds: list[int | None] = []

    def note(*_: Any, seed: int | None = None, **__: Any) -> Verdict:
        seeds.append(seed)
        return Verdict(None, problem="only a test")

    monkeypatch.setattr(autograde, "judge", note)
    secret = tmp_path / "course.secret"
    secret.write_bytes(b"0123456789abcdef")
    step = autograde.JudgeNodes(secret=str(secret))
    plain, cells = autograde.JudgeNodes(), [("code", f"%%node {FILE}\n1")]
    for name, judging in (("ann", step), ("bob", step), ("ann", plain)):
        judging._verdict(SLUG, cells, Place("", "01_loop", "01_loop", name), tmp_path)
    key = secret.read_bytes()
    assert seeds == [student_key(key, "ann", SLUG), student_key(key, "bob", SLUG), None]


def test_one_file_of_two_is_graded_as_course_grade_grades_it() -> None:
    exercise = find_exercise("model_server")
    client = solution(exercise.slug, "detection_client.py")
    some = judge.judge(exercise, {"detection_client.py": client, "other.py": "x"})
    assert some.grading is not None
    assert 0 < some.grading["score"] < 100
    (told,) = [c for c in some.grading["checks"] if c["id"] == "server_wiring"]
    assert "there is no detection_server.py in the submission" in told["message"]


def test_without_a_secret_or_ros_nothing_begins(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    config = Config()
    config.JudgeNodes.trust = True
    config.JudgeNodes.secret = str(tmp_path / "missing")
    with pytest.raises(NbGraderException, match="cannot read the course's secret"):
        CourseExporter(config=config)

    def none(*_: object) -> None:
        raise GraderError("no ROS 2 here")

    monkeypatch.setattr(ForkServerPool, "of", none)
    with pytest.raises(NbGraderException, match="no ROS 2 here"):
        CourseExporter(config=Config())


def test_a_release_with_an_unknown_check_is_refused() -> None:
    cell = v4.new_code_cell('check("1:wirin")', metadata={"nbgrader": {"grade": True}})
    with pytest.raises(InputError, match="unknown check 'wirin' of obstacle_avoidance"):
        LeaveSkeletons().preprocess_cell(cell, {}, 0)


def test_nbgrader_finds_its_programs_where_python_is(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", "/usr/bin")
    config = Config()
    configure(config)
    assert os.environ["PATH"].endswith("/bin:/usr/bin")
    steps = [step.__name__ for step in config.Autograde.autograde_preprocessors]
    assert "Execute" not in steps
    assert "SaveAutoGrades" not in steps
    assert "JudgeNodes" in steps
