"""What clients ask and publish beside the grader's server, and their heartbeats."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from grader.checks.case import Case
from grader.checks.verdict import CheckFailed
from grader.exercises.model_server import clients
from grader.exercises.model_server.clients import DOUBLE, Request
from grader.exercises.model_server.notes import Answered, Asked

LIVE = object()


def recording(live: object = None, **others: Any) -> Any:
    double = SimpleNamespace(file=DOUBLE, start=0.0, stop=None, arguments=())
    scenario = SimpleNamespace(program=(double,))
    return SimpleNamespace(
        live=live,
        slack=0.0,
        duration_s=4.0,
        scenario=scenario,
        name="made up",
        endpoints=(),
        **others,
    )


def noted(monkeypatch: pytest.MonkeyPatch, *found: tuple[float, Asked | Answered]) -> None:
    monkeypatch.setattr(clients, "notes", lambda *_: list(found))


def test_a_request_from_before_the_beginning_is_none(monkeypatch: pytest.MonkeyPatch) -> None:
    noted(
        monkeypatch,
        (0.1, Answered(0, success=True, message="early", life=7)),  # its request was not noted
        (0.2, Asked(1, life=7)),
        (0.3, Asked(0, life=9)),  # another server, which counts anew
        (0.4, Answered(0, success=True, message="new", life=9)),
        (0.5, Answered(1, success=False, message="late", life=7)),
    )
    assert clients.requests(recording(LIVE)) == [
        Request(0.2, "", 0.5, success=False, message="late"),
        Request(0.3, "", 0.4, success=True, message="new"),
    ]
    with pytest.raises(CheckFailed, match="a topic of the grader's"):
        clients.requests(recording())


FINE = (Asked(0, kind="fine"), Answered(0, success=True, message="a"))
REFUSED = (Asked(0, kind="refused"), Answered(0, success=False, message="a"))


@pytest.mark.parametrize(
    ("answer", "heard", "right"),
    [
        (FINE, [(1.0, "a")], True),
        (FINE, [(1.6, "a")], True),  # with the next tick
        (FINE, [], False),
        (FINE, [(1.0, "b")], False),
        (FINE, [(1.0, "a"), (1.1, "a")], False),  # twice
        (FINE, [(1.0, "a"), (1.1, "b")], False),
        (REFUSED, [], True),
        (REFUSED, [(1.0, "a")], False),
    ],
)
def test_an_answer_with_success_is_published_once_and_nothing_else(
    monkeypatch: pytest.MonkeyPatch, answer: Any, heard: list[tuple[float, str]], right: bool
) -> None:
    noted(monkeypatch, *((1.0, note) for note in answer))
    said = [(time, "navigation", text) for time, text in heard]
    monkeypatch.setattr(clients, "detections", lambda _: said)
    found = [case for case in clients.cases(recording()) if "publish" in case.tags]
    assert all(case.allowed and not case.wrong() for case in found) is right


@pytest.mark.parametrize(
    ("took", "waits", "right"),
    [
        (0.0, 0.5, True),
        (0.3, 0.2, False),  # two at a time
        (0.7, 0.7, True),  # asks when the answer has come
        (2.0, 0.5, False),
        (2.0, 1.0, True),  # given up
        (2.0, 1.5, True),
        (2.0, 1.6, False),
        (0.0, 1.6, False),  # not every 0.5 s
    ],
)
def test_the_next_request_waits_for_the_answer_but_not_for_ever(
    monkeypatch: pytest.MonkeyPatch, took: float, waits: float, right: bool
) -> None:
    first = Answered(0, success=False, message="")
    noted(monkeypatch, (1.0, Asked(0)), (1.0 + waits, Asked(1)), (1.0 + took, first))
    monkeypatch.setattr(clients, "detections", lambda _: [])
    found: list[Case] = [c for c in clients.cases(recording()) if "patience" in c.tags]
    assert (not found[0].wrong()) is right
    assert ("owed" in found[0].tags) is (took > 1.0)


def heart(monkeypatch: pytest.MonkeyPatch, times: list[float], values: list[int]) -> Any:
    beats = [(t, SimpleNamespace(data=v)) for t, v in zip(times, values, strict=True)]
    monkeypatch.setattr(clients, "published", lambda *_: beats)
    monkeypatch.setattr(clients, "require_alive", lambda _: None)
    monkeypatch.setattr("grader.checks.words.require_alive", lambda _: None)
    return recording(times=lambda _: np.array(times))


TENTHS = [0.1 * i for i in range(1, 40)]


@pytest.mark.parametrize(
    ("times", "values", "right"),
    [
        (TENTHS, list(range(39)), True),
        (TENTHS, [0, *range(38)], False),
        (TENTHS[:20] + TENTHS[22:], list(range(37)), False),
        ([0.11 * i for i in range(1, 37)], list(range(36)), False),
        ([], [], False),
    ],
)
def test_a_heart_beats_ten_times_a_second_and_counts(
    monkeypatch: pytest.MonkeyPatch, times: list[float], values: list[int], right: bool
) -> None:
    beating = heart(monkeypatch, times, values)
    if right:
        clients.beats(beating)
        return
    with pytest.raises(CheckFailed):
        clients.beats(beating)


@pytest.mark.parametrize(
    ("times", "asked", "message"),
    [
        (TENTHS, [Request(0.5)], ""),
        (TENTHS, [], "no client ever asks"),
        ([0.2 * i for i in range(1, 20)], [Request(0.5)], ""),  # slow, but it never waits
        (TENTHS[:20] + TENTHS[25:], [Request(0.5)], "stood still for 0.60 s"),
        (TENTHS[:20], [Request(0.5)], "stood still for 2.00 s"),  # for good
    ],
)
def test_a_client_that_waits_stands_still(
    monkeypatch: pytest.MonkeyPatch, times: list[float], asked: list[Request], message: str
) -> None:
    monkeypatch.setattr(clients, "requests", lambda _: asked)
    runs: Any = [heart(monkeypatch, times, list(range(len(times))))]
    if not message:
        clients.goes_on(runs)
        return
    with pytest.raises(CheckFailed, match=message):
        clients.goes_on(runs)
