"""Files that others handed in: a right verdict, and a one-line reason where there is none."""

from typing import Any

import pytest

from grader.course.exercises import find_exercise
from grader.errors import GraderError
from grader.grading import handed_in
from grader.grading.handed_in import grade_files, isolation_problem
from rclpy_virtual_time import ForkServer

EXERCISE = find_exercise("obstacle_avoidance")
FILE = EXERCISE.files[0]


def test_a_skeleton_is_graded() -> None:
    files = {FILE: (EXERCISE.folder / FILE).read_bytes()}
    grading = grade_files(EXERCISE, files, trust=True)

    assert (grading["exercise"], grading["file"]) == (EXERCISE.slug, FILE)
    assert grading["score"] < grading["max_score"]


def test_without_trust_a_machine_with_weak_isolation_runs_nothing(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(ForkServer, "foreign_code", "too open")
    monkeypatch.setattr(handed_in, "grade_submission", lambda *_, **__: pytest.fail("ran"))

    assert isolation_problem() == "too open"
    with pytest.raises(GraderError, match="too open"):
        grade_files(EXERCISE, {FILE: b"pass"})


def test_a_fault_is_one_line_and_ends_the_fork_server(monkeypatch: pytest.MonkeyPatch) -> None:
    def fault(*_: Any, **__: Any) -> None:
        raise ValueError("two\nlines")

    monkeypatch.setattr(handed_in, "grade_submission", fault)
    with pytest.raises(GraderError, match=r"^the grader failed \(ValueError: two lines\)$"):
        grade_files(EXERCISE, {FILE: b"pass"}, trust=True)
    assert not handed_in._forkservers._warm
