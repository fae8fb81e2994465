"""How a status is read."""

from types import SimpleNamespace
from typing import Any

import pytest

from grader.checks.verdict import CheckFailed
from grader.exercises.latency_monitor import reports
from grader.exercises.latency_monitor.contract import KEYS
from grader.exercises.latency_monitor.reports import NAME, form


def status(name: str = NAME, keys: tuple[str, ...] = KEYS, value: str = "1.0") -> Any:
    return SimpleNamespace(
        name=name, values=[SimpleNamespace(key=key, value=value) for key in keys]
    )


@pytest.mark.parametrize(
    ("statuses", "wrong", "came"),
    [
        ([], "status", "none"),
        ([status(), status()], "status", f"{NAME}, {NAME}"),
        ([status(keys=("count",))], "mean_ms", None),
        ([status(value="1.0 ms")], "count", "1.0 ms"),
        ([status(value="nan")], "count", "nan"),
        ([status()], "", None),
    ],
)
def test_a_status_in_another_form_has_a_flaw(
    statuses: list[Any], wrong: str, came: str | None
) -> None:
    case = form(1.0, statuses)
    assert (case.wrong(), case.said.get(wrong)) == (wrong, came)


def test_reports_of_another_name_are_told_as_that(monkeypatch: pytest.MonkeyPatch) -> None:
    told = [(1.0, SimpleNamespace(status=[status("inference")]))]
    monkeypatch.setattr(reports, "published", lambda *_: told)
    runs: Any = [SimpleNamespace(name="run")]
    with pytest.raises(CheckFailed) as caught:
        reports.reports(runs, "count", help="")
    assert (caught.value.expected, caught.value.actual) == (NAME, "inference")
