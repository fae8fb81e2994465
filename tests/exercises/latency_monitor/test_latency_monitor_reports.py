"""How a status is read, and what is said of a latency in another unit."""

from types import SimpleNamespace
from typing import Any

import pytest

from grader.checks.case import Case, exactly
from grader.exercises.latency_monitor.contract import KEYS
from grader.exercises.latency_monitor.reports import DIGITS, NAME, form, slip


@pytest.mark.parametrize(
    ("key", "number", "wanted", "said"),
    [
        ("mean_ms", 9000.0, 9.0, "microseconds"),
        ("mean_ms", 0.009, 9.0, "These are seconds"),
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
    ("statuses", "field", "came"),
    [
        ([], "status", "none"),
        ([status(), status()], "status", f"{NAME}, {NAME}"),
        ([status(keys=("count",))], "keys", "count"),
        ([status(value="1.0 ms")], "values", "1.0 ms"),
        ([status()], "values", DIGITS),
    ],
)
def test_a_status_in_another_form_has_a_flaw(statuses: list[Any], field: str, came: str) -> None:
    assert form(statuses)[field] == came
