"""Exercise 7's occasions, and its own words for them."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from grader.checks.case import Case, Runs
from grader.exercises.safety_supervisor.contract import cases
from grader.exercises.safety_supervisor.words import one_a_tick, own_reason
from sim.messages import E_STOP_TOPIC, Message, bool_, twist

TICKS = [round(0.05 * i, 3) for i in range(1, 20)]


class Run:
    """A recording of one second, with as much as the oracle reads."""

    name, duration_s, slack, published = "a_run", 1.0, 0.0, ()
    outcome, scenario = SimpleNamespace(completed=True), SimpleNamespace(raw=())

    def __init__(self, times: list[float], speeds: list[float], *delivered: Message) -> None:
        values = np.zeros((len(times), 6))
        values[:, 0] = speeds
        self._twists = SimpleNamespace(t=np.array(times), values=values, linear_x=values[:, 0])
        self.delivered = delivered

    def twists(self) -> SimpleNamespace:
        return self._twists

    def scans(self) -> tuple[()]:
        return ()

    def times(self, topic: str) -> np.ndarray:
        return self._twists.t if topic == "/cmd_vel" else np.array([])


def runs(*recordings: Any) -> Runs:
    return Runs(recordings, cases, "safety_supervisor")


def pressed(time: float, data: bool = True) -> Message:
    return bool_(E_STOP_TOPIC, round(time * 1e9), data)


def test_each_tick_has_its_reason() -> None:
    raw = twist(time=120_000_000, linear_x=0.5, topic="/cmd_vel_raw")
    run: Any = Run(TICKS, [0.0] * 19, raw, pressed(0.32), pressed(0.52, False))
    found = {round(case.at, 2): case for case in cases(run) if "angular.z" in case.allowed}
    assert found[0.1].tags == {"stale_command"}
    assert found[0.2].tags == {"stale_scan"}
    assert found[0.4].tags == {"e_stop"}
    assert found[0.55].tags == {"stale_scan"}
    assert found[0.7].tags == {"stale_command", "settled"}


def test_a_silent_node_is_asked_at_each_tick() -> None:
    run: Any = Run([0.05], [0.3])
    later = [case for case in cases(run) if "angular.z" in case.allowed][1:]
    assert [round(case.at, 2) for case in later] == [round(0.35 + 0.05 * i, 2) for i in range(13)]
    assert all(case.count == 0 and case.wrong() == "linear.x" for case in later)


@pytest.mark.parametrize(
    "times", [TICKS, sorted([*TICKS, 0.52]), [t + 0.021 for t in TICKS]], ids=["", "extra", "phase"]
)
def test_a_zero_at_once_on_e_stop_is_allowed_besides(times: list[float]) -> None:
    run: Any = Run(times, [0.0] * len(times), pressed(0.52))
    one_a_tick(run)


@pytest.mark.parametrize(
    ("named", "right", "asked"),
    [("e_stop", {"obstacle"}, True), ("obstacle", {"obstacle"}, False), ("", {"obstacle"}, False)],
)
def test_a_node_is_asked_about_the_reason_that_it_names(
    named: str, right: set[str], asked: bool
) -> None:
    case = Case(1.0, "0.4 m ahead", frozenset({*right, "settled"}), said={"reason": named})
    assert (f"Your node says {named} here" in own_reason(case)) is asked
