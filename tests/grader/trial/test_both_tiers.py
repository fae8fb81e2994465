"""A right node and a wrong one are judged in real time, on DDS, as they are in virtual time."""

from pathlib import Path

import pytest

from grader.claims.mutants import find_mutant
from grader.course.exercises import find_exercise
from grader.course.submission import find_submission
from grader.grading.grading import grade_submission
from grader.launchers import fork_server

pytestmark = pytest.mark.long

EXERCISE = find_exercise("obstacle_avoidance")
(FILE,) = EXERCISE.files
NODES = {
    (EXERCISE.solutions / FILE).read_text("utf-8"): set(),
    find_mutant(EXERCISE, "brakes_too_late").text: {"stop_zone"},
}


@pytest.mark.parametrize("text", NODES, ids=["reference", "brakes_too_late"])
def test_both_tiers_judge_alike(text: str, tmp_path: Path) -> None:
    (tmp_path / FILE).write_text(text, "utf-8")
    submission = find_submission(tmp_path / FILE, FILE, ())
    failed = {}
    with fork_server() as forkserver:
        for tier in (1, 2):
            grading = grade_submission(
                EXERCISE, submission, forkserver, file=FILE, tier=tier,
                only=("no_contact", "stop_zone", "sees_sides"),
            )  # fmt: skip
            failed[tier] = {check.id for check in grading.checks if check.outcome == "fail"}
    assert failed == {1: NODES[text], 2: NODES[text]}
