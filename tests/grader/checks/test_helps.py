"""What to look at next follows from what came: another unit, sign or reason is named."""

from types import SimpleNamespace
from typing import Any

import pytest

from grader.exercises.latency_monitor.evidence import _slip
from grader.exercises.safety_supervisor import evidence as safety
from grader.exercises.trend_memory.evidence import _sign


@pytest.mark.parametrize(
    ("value", "wrong_sign"), [(-1.121, True), (1.0, False), (-1.0, False), (0.0, False)]
)
def test_a_closing_speed_with_the_wrong_sign_is_told_so(value: float, wrong_sign: bool) -> None:
    assert bool(_sign(value, 1.1205, 1.1215)) is wrong_sign


@pytest.mark.parametrize(
    ("key", "number", "wanted", "said"),
    [
        ("mean_ms", 9000.0, 9.0, "microseconds"),
        ("mean_ms", 0.009, 9.0, "These are seconds"),
        ("p95_ms", 10.0, 10.45, "Rounded"),
        ("mean_ms", 497.0, 9.0, ""),
        ("mean_ms", 0.0, 9.0, ""),
        ("mean_ms", float("nan"), 9.0, ""),
        ("count", 20.0, 20.5, ""),
    ],
)
def test_a_latency_in_another_unit_is_told_so(
    key: str, number: float, wanted: float, said: str
) -> None:
    told = _slip(key, number, wanted)
    assert said in told
    assert bool(told) is bool(said)


@pytest.mark.parametrize(
    ("says", "right", "asked"),
    [("e_stop", {"limited"}, True), ("limited", {"limited", "ok"}, False), ("", {"ok"}, False)],
)
def test_the_supervisor_is_asked_about_the_reason_that_it_names_itself(
    monkeypatch: pytest.MonkeyPatch, says: str, right: set[str], asked: bool
) -> None:
    found = [SimpleNamespace(t=1.0, reason="ok"), SimpleNamespace(t=2.0, reason=says)]
    later = SimpleNamespace(t=9.0, reason="bad_command")
    monkeypatch.setattr(safety, "reports", lambda _: [*found, later])
    tick: Any = SimpleNamespace(t=2.0, reasons=right)
    recording: Any = None

    assert (f"Your node says {says} here" in safety._own_reason(recording, tick)) is asked
