"""How a status is read, and what is said of a latency in another unit."""

from types import SimpleNamespace
from typing import Any

import pytest

from grader.checks.case import Case, exactly
from grader.exercises.latency_monitor.contract import KEYS
from grader.exercises.latency_monitor.reports import NAME, _flaw, slip


@pytest.mark.parametrize(
    ("key", "number", "wanted", "said"),
    [
        ("mean_ms", 9000.0, 9.0, "microseconds"),
        ("mean_ms", 0.009, 9.0, "These are seconds"),
        ("p95_ms", 10.0, 10.45, "Rounded"),
        ("mean_ms", 497.0, 9.0, ""),
        ("mean_ms", "9 ms", 9.0, ""),
    ],
)
def test_a_latency_in_another_unit_is_named(
    key: str, number: float | str, wanted: float, said: str
) -> None:
    advice = slip(Case(1.0, "a report", allowed={key: exactly(wanted)}, said={key: number}))
    assert said in advice
    assert bool(advice) is bool(said)


def status(name: str = NAME, keys: tuple[str, ...] = KEYS, value: str = "1.0") -> Any:
    return SimpleNamespace(
        name=name, values=[SimpleNamespace(key=key, value=value) for key in keys]
    )


@pytest.mark.parametrize(
    ("statuses", "came"),
    [
        ([], "no status"),
        ([status(), status()], NAME),
        ([status(value="1.0 ms")], "count is “1.0 ms”"),
    ],
)
def test_a_status_in_another_form_has_a_flaw(statuses: list[Any], came: str) -> None:
    flaw = _flaw(statuses)
    assert flaw
    assert came in flaw[1]
    assert _flaw([status()]) is None
