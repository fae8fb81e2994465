"""The judge of a notebook in the browser, beside a worker that has nothing but bad news.

tests/browser/test_lite.py has the real one.
"""

from pathlib import Path
from typing import Any

import pytest

from grader.course.exercises import find_exercise
from grader.errors import GraderError, InputError
from grader.notebook import page
from grader.notebook.orders import Grade, Problem
from grader.trial.progress import Step

EXERCISE = find_exercise("1")
FILE = EXERCISE.solutions / EXERCISE.files[0]


class BadNews:
    """A worker in which nothing runs to its end."""

    exercises = frozenset({EXERCISE.slug})

    def __init__(self, error: Exception) -> None:
        self.error = error
        self.asked: list[Any] = []

    def run(self, call: str, order: Any, files: Any) -> Any:
        self.asked.append((call, order["scenario"], sorted(files)))
        raise self.error


@pytest.mark.parametrize("error", [InputError("a loop never ends"), GraderError("no memory")])
def test_what_stops_a_trial_is_said_once_and_nothing_is_judged(error: Exception) -> None:
    worker: Any = BadNews(error)
    with pytest.raises(type(error), match=str(error)):
        page._grade(Grade(EXERCISE.slug, str(FILE), FILE.name), worker, lambda _: None)
    assert [(call, files) for call, _, files in worker.asked] == [("trial", [FILE.name])]


def test_an_exercise_that_no_page_has_is_named() -> None:
    worker: Any = BadNews(AssertionError("nothing may run"))
    answer = page._grade(Grade("ml_velocity", str(FILE), FILE.name), worker, lambda _: None)
    assert isinstance(answer, Problem) and "exercise 2 can't be judged" in answer.text


def test_field_checks_are_missed_by_name_and_the_others_are_judged(
    capsys: pytest.CaptureFixture[str],
) -> None:
    worker: Any = BadNews(InputError("asked"))
    with pytest.raises(InputError, match="asked"):
        page._grade(Grade(EXERCISE.slug, str(FILE), FILE.name, field=True), worker, lambda _: None)
    assert capsys.readouterr().out == f"{page.FIELD}\n"


def test_progress_counts_the_trials_that_are_planned(tmp_path: Path) -> None:
    steps: list[Step] = []
    trials = page.WorkerTrials(BadNews(InputError("")), EXERCISE, FILE, steps.append)  # type: ignore[arg-type]
    trials.prepare(["avoid_zones", "avoid_wall"])
    with pytest.raises(InputError):
        trials.get("avoid_zones")
    assert [(step.done, step.of, step.name) for step in steps] == [(0, 2, "avoid_zones")]
