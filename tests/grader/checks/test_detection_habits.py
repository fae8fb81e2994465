"""What a server or a client always does wrong, by what it does in plain scenarios."""

import json
import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from msgspec.structs import replace

from grader.checks.verdict import CheckFailed
from grader.exercises.model_server import answers, clients, habits
from grader.exercises.model_server.answers import Ask, require_asked_features
from grader.exercises.model_server.habits import claims, gives_reasons, trusts_success
from grader.recording import Inference, Scan

OBJECT = json.dumps({"label": "free", "confidence": 0.9, "stamp": 1.0})
SCAN = Scan(
    t=1.0,
    stamp=1.0,
    ranges=np.full(360, 2.0, np.float32),
    angle_min=-math.pi,
    angle_increment=math.tau / 360,
    range_min=0.15,
    range_max=12.0,
)


def ask(success: bool, message: str, scan: Scan | None = SCAN, *, answered: bool = True) -> Ask:
    return Ask(1.05, answered, success, message, scan, until=1.06)


def told(monkeypatch: pytest.MonkeyPatch, says: list[Ask], early: list[Ask]) -> tuple[Any, Any]:
    said = {"says": says, "early": early}
    monkeypatch.setattr(habits, "asks", lambda which: said[which])
    return "says", "early"


GOOD, FORGOTTEN = ask(True, OBJECT), ask(False, OBJECT)
REFUSED, CLAIMED = ask(False, "no scan", None), ask(True, "no scan", None)


@pytest.mark.parametrize(
    ("says", "early", "trusts"),
    [
        ([GOOD, GOOD], [REFUSED], True),
        ([FORGOTTEN, FORGOTTEN], [REFUSED], False),
        ([FORGOTTEN, GOOD], [REFUSED], True),  # it knows how to set it
        ([ask(False, "broken")], [REFUSED], True),  # a refusal
        ([ask(False, "", answered=False)], [REFUSED], True),
        ([GOOD], [CLAIMED], False),
        ([GOOD], [ask(True, OBJECT, None)], True),  # it makes a detection up
        ([GOOD], [ask(True, " ", None)], True),  # and says no reason
        ([GOOD], [ask(True, "broken")], True),  # the scan has come
    ],
)
def test_success_is_trusted_unless_it_is_always_wrong(
    monkeypatch: pytest.MonkeyPatch, says: list[Ask], early: list[Ask], trusts: bool
) -> None:
    assert trusts_success(*told(monkeypatch, says, early)) is trusts


@pytest.mark.parametrize(
    ("early", "gives"),
    [
        ([REFUSED, REFUSED], True),
        ([REFUSED, ask(False, " ", None)], False),
        ([ask(True, "", None)], True),  # that is no refusal
        ([ask(False, "", None, answered=False)], True),  # nor is that
    ],
)
def test_who_refuses_says_why(
    monkeypatch: pytest.MonkeyPatch, early: list[Ask], gives: bool
) -> None:
    monkeypatch.setattr(habits, "asks", lambda _: early)
    recording: Any = "early"
    assert gives_reasons(recording) is gives


@pytest.mark.parametrize(
    "message", ["", "[1]", "3", "null", "{'label': 1}", "[" * 100_000, OBJECT + " " * 10_000]
)
def test_only_an_object_claims_a_detection(message: str) -> None:
    assert not claims(ask(True, message))
    assert claims(ask(False, OBJECT))


@pytest.mark.parametrize(
    ("words", "right"),
    [
        (["2 2 0 2 2"], True),
        (["2 2 0 2 2", "2 2 0 2 3"], False),  # the right question among others
        (["2 2 0 3 2"], False),
        (["free"], False),
        ([], False),
    ],
)
def test_features_are_those_that_the_model_was_asked_about(words: list[str], right: bool) -> None:
    asked = [
        Inference("predict", "m", 1_010_000_000, 1_020_000_000, 0, (), labels=(word,))
        for word in words
    ]
    recording: Any = SimpleNamespace(live=None, slack=0.0, inferences=asked, name="detect_answers")
    if right:
        require_asked_features(recording, ask(True, "{'label': 0}"))
        return
    with pytest.raises(CheckFailed):
        require_asked_features(recording, ask(True, "{'label': 0}"))


def test_who_asks_for_probabilities_only_is_judged_by_the_features_of_those() -> None:
    asked = Inference("predict_proba", "m", 1_010_000_000, 1_020_000_000, 0, (0.8,))
    words = ("2 2 0 2 2",)
    recording: Any = SimpleNamespace(live=None, slack=0.0, name="detect_answers")
    recording.inferences = [replace(asked, labels=words)]
    require_asked_features(recording, ask(True, OBJECT))
    recording.inferences = [asked]
    with pytest.raises(CheckFailed):
        require_asked_features(recording, ask(True, OBJECT))


def heart(monkeypatch: pytest.MonkeyPatch, times: list[float], values: list[int]) -> Any:
    monkeypatch.setattr(clients, "require_alive", lambda _: None)
    monkeypatch.setattr(clients, "roles", lambda _: ["navigation"])
    monkeypatch.setattr(clients, "beats", lambda *_: (np.array(times), values))
    return SimpleNamespace(duration_s=4.0, slack=0.0, name="detect_quick_server")


@pytest.mark.parametrize(
    ("times", "values", "right"),
    [
        ([0.1, 0.2, 0.3, 0.4], [0, 1, 2, 3], True),
        ([0.1, 0.2, 0.3, 0.4], [0, 1, 1, 2], False),
        ([0.1, 0.3, 0.4], [0, 1, 2], False),
        ([0.4], [0], False),
        ([], [], False),
    ],
)
def test_before_it_stands_still_a_heart_beats(
    monkeypatch: pytest.MonkeyPatch, times: list[float], values: list[int], right: bool
) -> None:
    recording = heart(monkeypatch, times, values)
    with pytest.raises(CheckFailed):
        clients.require_heartbeat(recording)
    if right:
        clients.require_heartbeat(recording, until=0.5)
        return
    with pytest.raises(CheckFailed):
        clients.require_heartbeat(recording, until=0.5)


@pytest.mark.parametrize("asked", [[], [clients.Request(0, 0.5, 0.8)]])
def test_who_never_asks_can_wait_for_nothing(
    monkeypatch: pytest.MonkeyPatch, asked: list[clients.Request]
) -> None:
    monkeypatch.setattr(clients, "requests", lambda _: asked)
    recording = heart(monkeypatch, [0.1 * i for i in range(1, 40)], list(range(39)))
    if asked:
        clients.require_unblocked(recording)
        return
    with pytest.raises(CheckFailed, match="no client ever asks"):
        clients.require_unblocked(recording)


def test_the_answers_of_a_contract_may_be_read_in_another_way(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(answers, "require_alive", lambda _: None)
    monkeypatch.setattr(answers, "asks", lambda _: [FORGOTTEN])
    recording: Any = SimpleNamespace(name="detect_answers")
    judged: list[Ask] = []
    with pytest.raises(CheckFailed, match="refused"):
        answers.require_contract(recording)
    answers.require_contract(
        recording, judged=[GOOD], features=lambda _, ask, __: judged.append(ask)
    )
    assert judged == [GOOD]
