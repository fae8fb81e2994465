"""`course next`: what to do, from what passed last."""

from collections.abc import Callable
from pathlib import Path

import pytest

from grader.course.exercises import Exercise, find_exercise
from grader.grading.attempts import since_last
from grader.grading.grading import Grading, grade
from grader.grading.onward import onward
from grader.grading.plugin import CheckResult
from grader.trial.trials import SavedTrials

FIRST, SECOND = find_exercise("1"), find_exercise("2")
Graded = Callable[..., Path]


@pytest.fixture
def graded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Graded:
    """Remember a grading in which all passed but these; the file that was graded."""
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    monkeypatch.chdir(tmp_path)

    def remember(exercise: Exercise, *failed: str, field: bool = False, unjudged: str = "") -> Path:
        path = tmp_path / exercise.files[0]
        path.touch()
        known = grade(exercise, SavedTrials([]), file=path.name, field=field).checks
        checks = [
            CheckResult(
                check.id, check.title, check.kind, 0, check.max_points,
                "fail" if check.id in failed else "unavailable" if check.id == unjudged else "pass",
            )
            for check in known
        ]  # fmt: skip
        since_last(Grading(exercise, path.name, 1, tuple(checks), ()), path)
        return path

    return remember


def test_before_the_first_grading_one_begins(graded: Graded) -> None:
    assert onward() == ["Nothing has been graded here yet. Begin with", "  course start"]
    assert onward(SECOND)[-1] == "  course start 2"


def test_the_first_task_that_fails_comes_next(graded: Graded) -> None:
    graded(FIRST, "drives_on", "stop_zone", unjudged="wiring")
    said, command = onward()
    assert said.startswith("Exercise 1: 12 of 15 checks pass. Next comes task 4: Below 0.5 m")
    assert command == "  course grade 1 obstacle_avoidance_agent.py --only stop_zone"
    graded(FIRST, unjudged="wiring")  # what was never judged comes last
    assert onward()[-1].endswith("--only wiring")


def test_after_full_marks_come_the_badge_a_challenge_and_the_next_exercise(graded: Graded) -> None:
    graded(FIRST)
    assert [line for line in onward() if line.startswith("  ")] == [
        "  course grade 1 obstacle_avoidance_agent.py --field",
        "  course race 1 obstacle_avoidance_agent.py",
        "  course start 2",
    ]
    graded(FIRST, field=True)
    assert [line for line in onward() if line.startswith("  ")] == [
        "  course search obstacle_avoidance_agent.py --exercise 1",
        "  course race 1 obstacle_avoidance_agent.py",
        "  course start 2",
    ]
    graded(SECOND, "drives")  # the one graded last, unless one is asked for
    assert onward()[0].startswith("Exercise 2: ")
    assert onward(FIRST)[0].startswith("Exercise 1: full marks")
    assert onward(FIRST)[-1] == "  course start 3"  # the second is begun


def test_a_file_that_is_gone_is_forgotten(graded: Graded) -> None:
    graded(FIRST).unlink()
    assert onward()[-1] == "  course start"
