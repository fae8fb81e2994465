"""How a status is read, and what is said of a latency in another unit."""

from types import SimpleNamespace
from typing import Any

import pytest

from grader.checks.case import Case, Runs, exactly
from grader.checks.verdict import CheckFailed
from grader.exercises.latency_monitor import calls
from grader.exercises.latency_monitor.contract import KEYS
from grader.exercises.latency_monitor.reports import NAME, _flaw, _number, slip
from grader.recording import Inference


@pytest.mark.parametrize(
    ("key", "number", "wanted", "said"),
    [
        ("mean_ms", 9000.0, 9.0, "microseconds"),
        ("mean_ms", 0.009, 9.0, "These are seconds"),
        ("p95_ms", 10.0, 10.45, "Rounded"),
        ("mean_ms", 497.0, 9.0, ""),
        ("mean_ms", 0.0, 9.0, ""),
        ("mean_ms", "9 ms", 9.0, ""),
        ("count", 20.0, 20.5, ""),
    ],
)
def test_a_latency_in_another_unit_is_named(
    key: str, number: float | str, wanted: float, said: str
) -> None:
    advice = slip(Case(1.0, "a report", allowed={key: exactly(wanted)}, said={key: number}))
    assert said in advice
    assert bool(advice) is bool(said)


@pytest.mark.parametrize("text", ["12.3 ms", "nan", "inf", "many", ""])
def test_what_is_no_decimal_number_stays_a_text(text: str) -> None:
    assert _number(text) == text
    assert _number("12.3") == 12.3


def status(name: str = NAME, keys: tuple[str, ...] = KEYS, value: str = "1.0") -> Any:
    return SimpleNamespace(
        name=name, values=[SimpleNamespace(key=key, value=value) for key in keys]
    )


@pytest.mark.parametrize(
    ("statuses", "came"),
    [
        ([], "no status"),
        ([status("mine")], "mine"),
        ([status(), status()], NAME),
        ([status(keys=KEYS[:-1])], "count"),
        ([status(keys=(*KEYS, "count"))], "count"),
        ([status(value="1.0 ms")], "count is “1.0 ms”"),
    ],
)
def test_a_status_in_another_form_has_a_flaw(statuses: list[Any], came: str) -> None:
    flaw = _flaw(statuses)
    assert flaw
    assert came in flaw[1]
    assert _flaw([status()]) is None


def test_a_second_call_for_a_scan_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = [Inference("predict", "m", i * 10**8, i * 10**8 + 1, 1, (0.1,)) for i in (1, 2, 3)]
    recording: Any = SimpleNamespace(
        name="latency_raises",
        slack=0.0,
        inferences=asked,
        outcome=SimpleNamespace(completed=True),
        scans=lambda: [SimpleNamespace(t=i / 10) for i in (1, 2, 3)],
    )
    monkeypatch.setattr(calls, "_require_a_call_each", lambda *_: None)
    calls.asks_once_each(Runs([recording], lambda _: ()))

    recording.inferences = asked[:1] * 3
    with pytest.raises(CheckFailed, match="called again for the scan"):
        calls.asks_once_each(Runs([recording], lambda _: ()))
