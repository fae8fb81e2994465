"""What clients ask and publish beside the grader's server, and their heartbeats."""

from types import SimpleNamespace
from typing import Any

import pytest

from grader.checks.case import Case
from grader.exercises.model_server import clients
from grader.exercises.model_server.clients import FIRST, PAUSE
from grader.exercises.model_server.notes import Request
from grader.models.partners import DOUBLE


def recording() -> Any:
    double = SimpleNamespace(file=DOUBLE, start=0.0, stop=None, arguments=())
    scenario = SimpleNamespace(program=(double,))
    return SimpleNamespace(
        live=None, slack=0.0, duration_s=4.0, scenario=scenario, name="made up", endpoints=()
    )


@pytest.mark.parametrize(
    ("took", "waits", "right"),
    [
        (0.0, 0.5, True),
        (0.3, 0.2, False),  # two at a time
        (0.7, 0.7, True),  # asks when the answer has come
        (2.0, 1.0, True),  # given up
        (2.0, 1.6, False),
    ],
)
def test_the_next_request_waits_for_the_answer_but_not_for_ever(
    monkeypatch: pytest.MonkeyPatch, took: float, waits: float, right: bool
) -> None:
    asked = [Request(1.0, answered=1.0 + took), Request(1.0 + waits)]
    monkeypatch.setattr(clients, "requests", lambda _: asked)
    monkeypatch.setattr(clients, "published", lambda *_: [])
    found: list[Case] = [c for c in clients.cases(recording()) if "patience" in c.tags]
    assert (not found[0].wrong()) is right


TENTHS = [0.1 * i for i in range(1, 40)]


@pytest.mark.parametrize(
    ("times", "asked", "wrong"),
    [
        (TENTHS, [], FIRST),
        ([0.2 * i for i in range(1, 20)], [Request(0.5)], ""),  # slow, but it never waits
        (TENTHS[:20] + TENTHS[25:], [Request(0.5)], PAUSE),
        (TENTHS[:20], [Request(0.5)], PAUSE),  # for good
    ],
)
def test_a_client_that_waits_stands_still(
    monkeypatch: pytest.MonkeyPatch, times: list[float], asked: list[Request], wrong: str
) -> None:
    beats = [(t, SimpleNamespace(data=i)) for i, t in enumerate(times)]
    monkeypatch.setattr(clients, "requests", lambda _: asked)
    monkeypatch.setattr(clients, "published", lambda *_: beats)
    monkeypatch.setattr(clients, "_publications", lambda *_: [])
    found = {c.wrong() for c in clients.cases(recording()) if "goes_on" in c.tags}
    assert found - {""} == ({wrong} if wrong else set())
