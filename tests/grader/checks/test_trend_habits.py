"""What a node's closing speeds are made of, by what it says of plain readings."""

import math
from collections.abc import Callable

import numpy as np
import pytest

from grader.exercises.trend_memory.contract import RIGHT, Law, Step, closing_speed, steps
from grader.exercises.trend_memory.habits import APPROACH, CHANGES, STAMPS, Habits, Shown, habits_of
from grader.recording import Scan
from sim.scenario_files import load_scenario

NEVER = 10**6  # readings


def plain(name: str, every: float = 0.1) -> list[Step]:
    """Return the steps of a plain scenario, as its bench has them."""
    scans = [
        Scan(
            t=every * i,
            stamp=1.7e9 + every * i,
            ranges=np.full(360, bench.fill, np.float32),
            angle_min=-math.pi,
            angle_increment=math.tau / 360,
            range_min=0.15,
            range_max=12.0,
        )
        for i, bench in enumerate(load_scenario(name).bench_scans)
    ]
    return steps(tuple(scans))


def shown(say: Callable[[Step], float], least: int = 10, stamps: float = 0.13) -> dict[str, Shown]:
    """Return what a node shows that says this from the least-th reading on."""
    return {
        name: tuple(
            (step, (say(step),) if len(step.readings) >= least else ())
            for step in plain(name, stamps if name == STAMPS else 0.1)
        )
        for name in (APPROACH, CHANGES, STAMPS)
    }


def by(law: Law) -> Callable[[Step], float]:
    def say(step: Step) -> float:
        value = closing_speed(step.readings, law)
        return round(value / law.grain) * law.grain if law.grain else value

    return say


@pytest.mark.parametrize(
    "law",
    [
        RIGHT,
        Law("slope", keeps=None),
        Law("slope", keeps=20),
        Law("slope", first=True),
        Law("slope", counts=True),
        Law("first and last"),
        Law("time over distance"),
        Law("whole seconds"),
        Law("slope", grain=0.01),
    ],
)
def test_the_law_behind_the_numbers_is_found(law: Law) -> None:
    assert habits_of(shown(by(law))) == Habits(law)


@pytest.mark.parametrize("scale", [-1.0, 0.1, 1000.0, -100.0])
def test_the_sign_and_the_unit_are_found(scale: float) -> None:
    law = habits_of(shown(by(Law("slope", scale)))).law
    assert law is not None
    assert law._replace(scale=1.0) == RIGHT
    assert law.scale == pytest.approx(scale)


@pytest.mark.parametrize("value", [0.0, 1.0, 1e-4, 1e-315, 1e9, math.nan, math.inf])
def test_a_constant_follows_no_law(value: float) -> None:
    assert habits_of(shown(lambda _: value)).law is None


def test_the_distance_is_no_closing_speed() -> None:
    assert habits_of(shown(lambda step: step.readings[-1][1])).law is None


def test_silence_follows_no_law() -> None:
    assert habits_of(shown(by(RIGHT), least=NEVER)) == Habits(None, regular=False)


def test_a_node_that_speaks_too_early_is_known() -> None:
    assert habits_of(shown(by(RIGHT), least=2)) == Habits(RIGHT, early=True)


def test_a_node_that_skips_readings_is_known() -> None:
    assert not habits_of(shown(by(RIGHT), least=11)).regular


def test_no_rule_is_looked_for_in_a_flood() -> None:
    """The search would take the judge minutes."""
    doubled = by(Law("slope", 2.0))
    flood = {
        name: tuple((step, values * 300) for step, values in trial)
        for name, trial in shown(doubled).items()
    }
    assert habits_of(shown(doubled)).law == Law("slope", 2.0)
    assert habits_of(flood).law is None


def test_ten_equal_stamps_ask_for_nothing() -> None:
    asked = [step for step in plain(APPROACH, every=0.0) if step.known == 10]
    assert asked
    assert not any(step.silent or step.spoken for step in asked)
