"""The core checks of exercise 6's server, 60 points: how it answers the grader's own client."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace

import pytest

from grader.checks.inferences import loads, require_kept
from grader.checks.verdict import fail
from grader.checks.wiring import require_alive, require_wiring
from grader.exercises.model_server.answers import (
    Ask,
    asked_about,
    asks,
    require_asked_features,
    require_contract,
    require_detection,
    require_features,
    require_refusal,
    require_success,
    words_of_model,
)
from grader.exercises.model_server.clients import detections
from grader.exercises.model_server.contract import ROLES, allowed
from grader.exercises.model_server.habits import (
    EARLY,
    SAYS,
    SLOW,
    claims,
    gives_reasons,
    goes_on,
    says_right,
    trusts_success,
)
from grader.recording import Recording
from sim.scenario import ProgramSpec

LOADED_AGAIN = (  # why some load a model again, in the words of a message
    "after the model had failed",
    "after a blind scan",
    "after an old scan",
    "some time after the start",
)

Recordings = tuple[Recording, ...]


@pytest.mark.check(points=5, scenarios=(SAYS,))
def test_server_wiring(recordings: Recordings) -> None:
    """The server starts, spins, listens to /scan and offers the service /detect."""
    for recording in recordings:
        require_wiring(recording, "model_server", "detection_server")
        if not any(ask.answered for ask in asks(recording)):
            fail(
                "the service /detect is there, but never answers",
                expected="a response to every request",
                actual="none",
                at=asks(recording)[0].at,
                recording=recording,
                help="Does main() spin the node? Does the callback return the response?",
            )


@pytest.mark.check(
    points=10, scenarios=(SAYS, "detect_hundred", "detect_numbers"), needs=("server_wiring",)
)
def test_answers(recordings: Recordings) -> None:
    """It answers with label, confidence and stamp of the newest scan, as JSON."""
    for recording in recordings:
        require_alive(recording)
        for ask in asks(recording):
            require_detection(recording, ask)


@pytest.mark.check(
    points=10,
    scenarios=(SAYS, EARLY, "detect_readings", "detect_limits"),
    needs=("server_wiring",),
)
def test_features(recordings: Recordings) -> None:
    """The model is asked about the five features of exercise 2."""
    says, early, *readings = recordings
    features = require_features if says_right(says) else require_asked_features
    for recording in (says, *readings):
        require_contract(recording, "", _told(recording, says, early), features)


@pytest.mark.check(points=5, scenarios=(EARLY, SAYS), needs=("server_wiring",))
def test_no_scan(recordings: Recordings) -> None:
    """Before the first scan it refuses, and says why."""
    early, says = recordings
    _require_refusals(
        early, _told(early, says), "Keep the scan in an attribute that is None at first."
    )


@pytest.mark.check(points=5, scenarios=("detect_late_scans", SAYS, EARLY), needs=("server_wiring",))
def test_old_scan(recordings: Recordings) -> None:
    """It refuses when the newest scan is older than 1 s, by the stamp in its header."""
    late, *shown = recordings
    _require_refusals(
        late,
        _told(late, *shown),
        "Compare the node's clock with header.stamp: a scan may have been long on its way.",
    )


@pytest.mark.check(points=5, scenarios=("detect_blind", SAYS, EARLY), needs=("server_wiring",))
def test_blind_sector(recordings: Recordings) -> None:
    """It refuses when a sector of the newest scan has no usable reading, and lives on."""
    blind, *shown = recordings
    _require_refusals(
        blind,
        _told(blind, *shown),
        "Only the newest scan counts, even if an older one has more to tell.",
    )


@pytest.mark.check(points=5, scenarios=("detect_no_model", SAYS, EARLY), needs=("server_wiring",))
def test_no_model(recordings: Recordings) -> None:
    """Without a model file, or with a broken one, it logs an error, starts and refuses."""
    recording, *shown = recordings
    require_alive(recording)
    lives = [p for p in recording.scenario.program if not p.supplied]
    broken, good = lives[:-1], lives[-1]
    for ask in _told(recording, *shown):
        if ask.at > good.start:
            require_success(recording, ask)
            continue
        paths = [p.arguments[-1] for p in broken if p.start < ask.at < (p.stop or 0)]
        why = f"the server was started with {paths[0] if paths else 'a model'}, which can't be "
        why += "loaded"
        require_refusal(recording, ask, why, "Catch whatever pickle.load raises.")
    for program in broken:
        _require_error(recording, program)


def _require_error(recording: Recording, server: ProgramSpec) -> None:
    """Fail unless this server, which has no model, logged an error."""
    begin, end = server.start, server.stop or recording.duration_s
    if any(line.level in ("error", "fatal") and begin <= line.t <= end for line in recording.log):
        return
    fail(
        "the server has no model, and its log does not say so",
        expected="an error in the log: self.get_logger().error(…)",
        actual="none",
        at=begin,
        recording=recording,
        help="Log which file cannot be loaded, and why.",
    )


@pytest.mark.check(
    points=5, scenarios=("detect_failing_model", SAYS, EARLY), needs=("server_wiring",)
)
def test_failing_model(recordings: Recordings) -> None:
    """It refuses when the model raises or its confidence is not finite, and lives on."""
    recording, *shown = recordings
    require_alive(recording)
    for ask in _told(recording, *shown):
        if "fails" in ask.tags:
            require_refusal(
                recording,
                ask,
                "the model failed",
                "Put predict and predict_proba into try … except Exception, and test the "
                "confidence with math.isfinite.",
            )
            _require_tried(recording, ask)
        elif allowed(ask.scan, ask.at).detection:  # in real time the first scan may come late
            require_success(recording, ask)


def _require_tried(recording: Recording, ask: Ask) -> None:
    """Fail unless the model was asked, and failed: a server can't know it before."""
    asked = [i for m in ("predict", "predict_proba") for i in asked_about(recording, ask, m)]
    if any(i.failed or not all(map(math.isfinite, i.said)) for i in asked):
        return
    fail(
        f"{ask.what}, the server refused without asking the model",
        expected="a question to predict and predict_proba, and a refusal because they fail",
        actual=f"{len(asked)} answers of the model, none of which failed"
        if asked
        else "no question",
        at=ask.at,
        recording=recording,
        help="Nobody can know what a model will say without asking it.",
    )


@pytest.mark.check(
    points=10,
    scenarios=(
        "detect_together",
        SLOW,
        SAYS,
        EARLY,
        "detect_failing_model",
        "detect_blind",
        "detect_late_scans",
        "detect_hundred",
    ),
    needs=("server_wiring", "client_wiring"),
)
def test_one_load(recordings: Recordings) -> None:
    """Three clients and one more ask, and the model is loaded once in the whole system."""
    recording, slow, says, early, *kept = recordings
    shown = (says, early)
    require_alive(recording)
    if goes_on(slow) and trusts_success(*shown):
        _require_heard(recording)
    for ask in _told(recording, *shown):
        require_success(recording, ask)
        count = sum(load.asked / 1e9 <= ask.at for load in loads(recording))
        if count != 1:
            fail(
                f"by {ask.at:.2f} s the model had been loaded {count} times",
                expected="one load: in the server's constructor",
                actual=f"{count} loads",
                at=ask.at,
                recording=recording,
                help="pickle.load belongs in the constructor of the server and nowhere else: "
                "the service is there so that one process has the model for all.",
            )
        if not _is_of_model(recording, ask, says_right(says)):
            fail(
                f"{ask.what}, the server said something else than its model",
                expected="the label that predict returns",
                actual=ask.message[:200],
                at=ask.at,
                recording=recording,
                help="Ask the model about the newest scan, and say what it answers.",
            )
    for other, after in zip(kept, LOADED_AGAIN, strict=True):
        require_kept(other, after)


def _is_of_model(recording: Recording, ask: Ask, by_word: bool) -> bool:
    """Tell whether an answer comes from the model, by what it says or by a question to it."""
    if by_word:
        return any(word in ask.message for word in words_of_model(recording, ask))
    return any(asked_about(recording, ask, method) for method in ("predict", "predict_proba"))


def _require_heard(recording: Recording) -> None:
    """Fail unless each client published a detection."""
    heard = detections(recording)
    for role in ROLES:
        if not any(who == role for _, who, _ in heard):
            fail(
                f"{role}_client never published a detection",
                expected=f"what the server says, on /{role}/detection",
                actual="nothing",
                at=next((ask.at for ask in asks(recording)), None),
                recording=recording,
                help="Look at how the server answers when three clients ask at once.",
            )


def _told(recording: Recording, *shown: Recording) -> list[Ask]:
    """Return each request with its answer, as habits in the scenarios SAYS and EARLY read it.

    A detection is one by its message, if that says it better; who never says why needs no reason.
    """
    told = asks(recording)
    if not trusts_success(*shown):
        told = [replace(ask, success=claims(ask)) for ask in told]
    if len(shown) > 1 and not gives_reasons(shown[1]):  # which no_scan has said
        told = [ask if ask.success else replace(ask, message="no reason") for ask in told]
    return told


def _require_refusals(recording: Recording, told: Iterable[Ask], help: str) -> None:
    """Fail unless the server refuses where it has to, and nowhere else."""
    require_alive(recording)
    judged = [(ask, allowed(ask.scan, ask.at)) for ask in told]
    for ask, right in judged:
        if not right.detection:
            require_refusal(recording, ask, right.reason, help)
        elif not right.refusal:
            require_success(recording, ask)
    kinds = {right.detection for _, right in judged}
    if kinds != {True, False}:
        fail("the scenario ended before all of its requests were sent", recording=recording)
