"""The page's way of grading, in CPython, against the grader's own: verdicts and messages."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from grader.authoring.mutants import find_mutant, mutants, submission_of
from grader.course.exercises import all_exercises, find_exercise
from grader.course.submission import find_submission
from grader.grading.grading import grade_submission
from grader.link.hosts import ForkServer
from workspace.plan import fields, methods, plan

FORKED = Path(__file__).with_name("forked.py")
TOLD = ("outcome", "message", "expected", "actual", "help", "time", "scenario", "where", "log")
GRADED = [
    ("1", None), ("1", "narrow_cone"), ("2", None), ("2", "loads_twice"), ("3", None),
    ("4", None), ("4", "reliable_only"), ("5", None), ("5", "worker_ends_with_an_exception"),
    ("6", None), ("6", "dies_of_the_other_exceptions"), ("6", "constructor_waits"), ("7", None),
    ("8", None), ("8", "suffix_within"), ("9", None), ("10", None), ("10", "clips"),
    ("11", None), ("11", "two_drivers"),
]  # fmt: skip
if os.environ.get("COURSE_PAGE") == "full":  # hours; -k "[7-" takes one exercise
    GRADED = [
        (str(exercise.number), each.name)
        for exercise in all_exercises()
        for each in mutants(exercise)
    ]


@pytest.mark.long
@pytest.mark.parametrize(("name", "mutant"), GRADED)
def test_the_page_judges_as_course_grade_does(
    forkserver: ForkServer, tmp_path: Path, name: str, mutant: str | None
) -> None:
    exercise = find_exercise(name)
    node = tmp_path / "node" / exercise.files[0]
    node.parent.mkdir()
    files = submission_of(exercise, find_mutant(exercise, mutant) if mutant else None)
    for file, text in files.items():
        node.with_name(file).write_text(text, "utf-8")
    submission = find_submission(node, *exercise.files[:1], exercise.files[1:])
    made = plan(exercise)
    here = [check["id"] for check in made["checks"] if check["scenarios"]]
    only = here if len(here) < len(made["checks"]) else ()  # or its trials come in another order
    expected = grade_submission(exercise, submission, forkserver, file=node.name, only=only)
    order = {
        "exercise": exercise.slug,
        "file": str(node),
        "others": list(exercise.files),
        "scenarios": list(made["scenarios"]),
    }
    done = subprocess.run(
        [sys.executable, FORKED, tmp_path],
        input=json.dumps(order),
        text=True,
        capture_output=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    judged = [check for check in found["checks"] if check["id"] in here]
    assert _told(judged) == _told(expected.as_dict()["checks"])
    assert found["cause"] == json.loads(json.dumps(expected.as_dict()["cause"]))
    assert found["practice"]


HERE = {"ml_velocity": 57, "model_formats": 32}  # points of checks without other libraries


THREADED = {  # in their trials other programs run beside the reader's
    "ml_velocity", "slow_model", "model_server", "latency_monitor", "live_parameters",
    "three_nodes",
}  # fmt: skip


def _told(checks: list[dict[str, object]]) -> dict[object, dict[str, object]]:
    return {check["id"]: {key: check[key] for key in TOLD} for check in checks}


@pytest.mark.parametrize("name", [exercise.slug for exercise in all_exercises()])
def test_the_plan_knows_every_core_check_and_what_it_needs(name: str) -> None:
    exercise = find_exercise(name)
    made = plan(exercise)
    assert sum(check["points"] for check in made["checks"]) == exercise.max_points
    here = sum(check["points"] for check in made["checks"] if check["scenarios"])
    assert here == HERE.get(name, exercise.max_points)
    assert made["threads"] == (name in THREADED)
    assert {s for check in made["checks"] for s in check["scenarios"]} == set(made["scenarios"])


def test_the_editor_is_told_of_methods_and_of_fields_of_fields() -> None:
    assert methods("class Node:\n    def spin(self): ...\n") == {"spin": "Node"}
    found = fields(find_exercise("latency_monitor"))
    told = {"ranges": "LaserScan", "x": "Vector3", "values": "DiagnosticStatus"}
    assert told.items() <= found.items()
