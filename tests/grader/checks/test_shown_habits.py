"""What a node does wrong throughout: it is seen where one check names it, and taken as given."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from grader.authoring.mutants import mutants
from grader.checks.verdict import CheckFailed
from grader.course.exercises import find_exercise
from grader.course.submission import Submission
from grader.exercises.safety_supervisor import habits as safety
from grader.exercises.safety_supervisor.contract import AS_ASKED, Habit, ticks
from grader.exercises.trend_memory import evidence as trend
from grader.exercises.trend_memory.contract import RIGHT
from grader.exercises.trend_memory.habits import PLAIN, SMALL, Habits
from grader.link.pool import ForkServerPool
from grader.recording import Recording
from grader.trial.virtual_time import run_trial
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
        ("e_stop_is_the_message", Habit(pressed="any")),
        ("e_stop_pressed_at_first", Habit(pressed="at first")),
        ("decides_with_the_scan", Habit(held=True)),
        ("e_stop_for_ever", AS_ASKED),  # as wrong, but what it does with a first false is right
        ("symmetric_ramp", AS_ASKED),  # right about the button
    ],
)
def test_the_button_and_the_moment_of_decision(run: Run, name: str, habit: Habit) -> None:
    (recording,) = run("safety_supervisor", name, safety.SHOWS)
    assert safety.habit_of((recording,)) == habit
    assert safety.button_of((recording,)) == habit._replace(held=False)
    if habit != AS_ASKED:
        assert not all(tick.is_right_but_for_the_rise for tick in ticks(recording))


def test_who_only_stands_has_no_habit(run: Run) -> None:
    (recording,) = run("safety_supervisor", "e_stop_is_the_message", safety.SHOWS)
    still = replace(
        recording,
        published=tuple(
            replace(each, data=bytes(len(each.data))) if each.topic == "/cmd_vel" else each
            for each in recording.published
        ),
    )
    assert not still.twists().values.any()
    assert safety.habit_of((still,)) == AS_ASKED


def test_numbers_that_are_noise_are_judged_with_small_stamps(run: Run) -> None:
    plain = run("trend_memory", "big_squares", *PLAIN, SMALL)
    assert trend.shown_habits(plain).law is None
    assert trend.told_by(plain, plain[:2]) == (Habits(RIGHT), plain[-1:])


def test_who_stands_for_wrong_closing_speeds_need_not_move(run: Run) -> None:
    wall, *plain = run("trend_memory", "axes_swapped", "trend_wall", *PLAIN)
    trend.require_way(wall, trend.shown_habits(plain))
    with pytest.raises(CheckFailed, match="hardly moved"):
        trend.require_way(wall, Habits())
