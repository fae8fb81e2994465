"""What a node does wrong throughout: it is seen where one check names it, and taken as given."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from grader.authoring.mutants import mutants
from grader.checks.verdict import CheckFailed
from grader.course.exercises import find_exercise
from grader.course.submission import Submission
from grader.exercises.ml_velocity import evidence as ml
from grader.exercises.ml_velocity.habits import Habit as Seeing
from grader.exercises.trend_memory import evidence as trend
from grader.exercises.trend_memory.contract import RIGHT
from grader.exercises.trend_memory.habits import PLAIN, SMALL, Habits
from grader.link.pool import ForkServerPool
from grader.recording import Recording
from grader.trial.virtual_time import run_trial
from sim.messages import twist
from sim.scenario_files import load_scenario

Run = Callable[..., tuple[Recording, ...]]


@pytest.fixture
def run(tmp_path: Path, forkservers: ForkServerPool) -> Run:
    """Return what a mutant of an exercise does in scenarios."""

    def of(slug: str, name: str, *scenarios: str) -> tuple[Recording, ...]:
        exercise = find_exercise(slug)
        file = tmp_path / "node.py"
        mutant = next(mutant for mutant in mutants(exercise) if mutant.name == name)
        file.write_text(mutant.text, "utf-8")
        forkserver = forkservers.of()
        return tuple(
            run_trial(Submission(file), load_scenario(each), forkserver) for each in scenarios
        )

    return of


@pytest.mark.parametrize(
    ("name", "habit"),
    [
        ("front_is_90_degrees", Seeing(front=90.0)),
        ("numpy_float_in_the_field", Seeing(garbage=True)),
        ("smoothes_the_prediction", Seeing(windows=tuple(range(8, 21)))),  # of eight scans
        ("features_in_another_order", Seeing()),
        ("keeps_what_hardly_changes", Seeing()),
        ("rounds_to_centimetres", Seeing(digits=2)),
        ("speeds_up_slowly", Seeing(step=pytest.approx(0.05))),
        ("slews", Seeing(step=pytest.approx(0.05))),
    ],
)
def test_sectors_and_filters(run: Run, name: str, habit: Seeing) -> None:
    (recording,) = run("ml_velocity", name, "ml_front_min")
    assert ml.habit_of((recording,)) == habit


@pytest.mark.parametrize("noise", [0.0, 1e-6])
def test_who_asks_the_model_and_stands_has_no_habit(run: Run, noise: float) -> None:
    (recording,) = run("ml_velocity", "rounds_to_centimetres", "ml_front_min")
    stands = replace(
        recording,
        published=tuple(
            replace(each, data=twist(time=0, linear_x=noise * (i % 2), topic="/cmd_vel").data)
            if each.topic == "/cmd_vel"
            else each
            for i, each in enumerate(recording.published)
        ),
    )
    assert len(stands.twists().linear_x) > 1
    assert ml.habit_of((stands,)) == Seeing()


def test_numbers_that_are_noise_are_judged_with_small_stamps(run: Run) -> None:
    plain = run("trend_memory", "big_squares", *PLAIN, SMALL)
    assert trend.shown_habits(plain).law is None
    assert trend.told_by(plain, plain[:2]) == (Habits(RIGHT), plain[-1:])


def test_who_stands_for_wrong_closing_speeds_need_not_move(run: Run) -> None:
    wall, *plain = run("trend_memory", "axes_swapped", "trend_wall", *PLAIN)
    trend.require_way(wall, trend.shown_habits(plain))
    with pytest.raises(CheckFailed, match="hardly moved"):
        trend.require_way(wall, Habits())
