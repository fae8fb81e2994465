"""Exercise 7 over time: which rule wins, jumps after a stop, and one command for each tick."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from grader.checks.verdict import CheckFailed
from grader.exercises.safety_supervisor import evidence, precedence, rises, timing
from grader.exercises.safety_supervisor.contract import Decision, Situation, Tick
from sim.messages import BOOL, E_STOP_TOPIC, bool_

NOTHING = Situation(False, (0.5, 0.0, 0.0, 0.0, 0.0, 0.0), 0.1, (2.0,), 0.1)
STOP, RISE = Decision("e_stop"), Decision("limited", speed=0.045, wish=0.5)
RULES = ("e_stop", "bad_command", "stale_command", "stale_scan", "obstacle")


def tick(t: float, speed: float = 0.0, right: Decision = STOP, matching: tuple = ()) -> Tick:
    return Tick(t, (speed, 0.0, 0.0, 0.0, 0.0, 0.0), NOTHING, (right,), matching, 1.0)


def first_match(
    monkeypatch: pytest.MonkeyPatch, said: dict[str, str], later: dict[str, str] | None = None
) -> None:
    """Judge a node by what it says where a rule matches that the next one follows, and later."""
    found, reports = [], []
    for number, (first, second) in enumerate(zip(RULES, [*RULES[1:], "limited"], strict=True)):
        begin = 1.0 + number
        found += [tick(begin + i * 0.05, matching=(first,)) for i in range(4)]
        found += [tick(begin + i * 0.05, matching=(first, second)) for i in range(4, 10)]
        reports.append(evidence.Report(begin, 1, 2, first))
        reports.append(evidence.Report(begin + 0.2, 1, 2, said.get(first, first)))
        if later and first in later:
            reports.append(evidence.Report(begin + 0.31, 1, 2, later[first]))
    monkeypatch.setattr(precedence, "ticks", lambda *_, **__: found)
    monkeypatch.setattr(precedence, "reports", lambda _: reports)
    recording: Any = SimpleNamespace(name="safe_first_match")
    precedence.require_first_match(recording, "In this order.")


@pytest.mark.parametrize("said", [{}, {"bad_command": "ok"}, {"e_stop": "ok", "obstacle": "ok"}])
def test_a_rule_that_a_node_gets_wrong_is_no_wrong_order(
    monkeypatch: pytest.MonkeyPatch, said: dict[str, str]
) -> None:
    first_match(monkeypatch, said)


def test_the_second_rule_must_not_win(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(CheckFailed, match="bad_command and stale_command match"):
        first_match(monkeypatch, {"bad_command": "stale_command"})


def test_the_first_rule_wins_for_as_long_as_it_matches(monkeypatch: pytest.MonkeyPatch) -> None:
    first_match(monkeypatch, {}, {"bad_command": "bad_command"})
    with pytest.raises(CheckFailed, match="bad_command and stale_command match"):
        first_match(monkeypatch, {}, {"bad_command": "stale_command"})


def test_a_node_that_always_says_the_same_shows_no_order(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(CheckFailed, match="too few reasons"):
        first_match(monkeypatch, dict.fromkeys(RULES, "ok"))


@pytest.mark.parametrize(
    ("speeds", "jumps"),
    [((0.0, 0.045), False), ((0.0, 0.0), False), ((0.0, 0.01), False), ((0.0, 0.5), True)],
)
def test_after_a_stop_only_a_jump_is_wrong(
    monkeypatch: pytest.MonkeyPatch, speeds: tuple[float, float], jumps: bool
) -> None:
    found = [tick(1.0, speeds[0]), tick(1.05, speeds[1], RISE)]
    monkeypatch.setattr(rises, "ticks", lambda *_, **__: found)
    monkeypatch.setattr(evidence, "reports", lambda _: [])
    recording: Any = SimpleNamespace(name="safe_obstacle")
    if jumps:
        with pytest.raises(CheckFailed, match="wrong command"):
            rises.require_no_jumps(recording)
    else:
        rises.require_no_jumps(recording)


def commands(times: list[float]) -> Any:
    """Return a recording of zeros at these times, with the button pressed at 0.52 s."""
    twists = SimpleNamespace(t=np.array(times), values=np.zeros((len(times), 6)))
    pressed = bool_(E_STOP_TOPIC, 520_000_000, True)
    assert pressed.type == BOOL
    return SimpleNamespace(
        name="safe_e_stop", duration_s=1.0, slack=0.0, delivered=[pressed], twists=lambda: twists,
        outcome=SimpleNamespace(completed=True),
    )  # fmt: skip


TICKS = [round(0.05 * i, 3) for i in range(1, 20)]


@pytest.mark.parametrize(
    "times", [TICKS, sorted([*TICKS, 0.52]), [t + 0.021 for t in TICKS]], ids=["", "extra", "phase"]
)
def test_a_zero_at_once_on_e_stop_is_allowed_besides(times: list[float]) -> None:
    timing.require_rate(commands(times))


@pytest.mark.parametrize("times", [TICKS[:10], sorted([*TICKS, *(t + 0.001 for t in TICKS)])])
def test_a_node_speaks_once_at_each_tick_while_it_stands(times: list[float]) -> None:
    with pytest.raises(CheckFailed):
        timing.require_rate(commands(times))


def test_two_numbers_that_differ_are_not_told_alike() -> None:
    assert evidence._apart(0.000122, 3, [0.0]) == "0.000122"
    assert evidence._apart(1.902, 2, [1.9]) == "1.902"
    assert evidence._apart(0.3, 3, [0.045]) == "0.300"


@pytest.mark.parametrize(
    ("turning", "right"),
    [
        ([True] * 80, True),
        ([True] * 20 + [False] * 30 + [True] * 30, True),  # it pauses for 1.5 s
        ([True] * 20 + [False] * 60, False),
        ([False] * 80, True),  # it never turns there: for the short trial to judge
    ],
)
def test_who_has_turned_before_a_thing_goes_on_turning(
    monkeypatch: pytest.MonkeyPatch, turning: list[bool], right: bool
) -> None:
    asked = Decision("obstacle", turn_rate=1.9)
    found = [
        Tick(
            i * 0.05, (0.0, 0.0, 0.0, 0.0, 0.0, 1.9 * turns), NOTHING, (asked,), ("obstacle",), 1.0
        )
        for i, turns in enumerate(turning)
    ]
    monkeypatch.setattr(evidence, "ticks", lambda *_, **__: found)
    monkeypatch.setattr(evidence, "reports", lambda _: [])
    recording: Any = SimpleNamespace(name="safe_for_long")
    if right:
        evidence.require_turning(recording, "obstacle", "Turn on.")
    else:
        with pytest.raises(CheckFailed, match="wrong command") as failed:
            evidence.require_turning(recording, "obstacle", "Turn on.")
        assert failed.value.at == pytest.approx(2.5)
