"""What the student's server was asked, how it answered, and whether that was right."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any, NoReturn

import numpy as np

from grader.checks.inferences import questions
from grader.checks.reading import published
from grader.checks.verdict import fail
from grader.checks.wiring import require_alive
from grader.exercises.model_server.contract import (
    CONFIDENCE_TOLERANCE,
    FEATURE_TOLERANCE,
    STAMP_TOLERANCE,
    Floats,
    allowed,
    spelt_features,
)
from grader.exercises.model_server.notes import (
    ASKED,
    START_UP,
    TOLD,
    Answered,
    notes,
    require_ours,
)
from grader.models.features import possible_features, scan_features, spell_features
from grader.recording import Inference, Recording, Scan
from sim.messages import UINT32

LONGEST = 10_000  # characters of a message; a detection has about a hundred
UNDER_WAY = 0.06  # [s] a scan may take to reach the server, in real time


@dataclass(frozen=True, eq=False)
class Ask:
    """A request of the grader's own client to the student's server."""

    at: float  # [s]
    answered: bool
    success: bool
    message: str
    scan: Scan | None  # the newest that the server had then
    label: str = ""  # of the bench scan
    tags: tuple[str, ...] = ()
    until: float = 0.0  # [s] when its answer came

    @property
    def what(self) -> str:
        """The request in words, for a student."""
        if self.scan is None:
            return f"asked at {self.at:.2f} s, before the first scan"
        if self.label:
            return f"asked about “{self.label}”"
        return f"asked at {self.at:.2f} s, {self.at - self.scan.stamp:.2f} s after the newest scan"


def asks(recording: Recording) -> list[Ask]:
    """Return each request to the server, with its answer."""
    require_ours(recording, ASKED)
    heard = [(at, note) for at, note in notes(recording, TOLD) if isinstance(note, Answered)]
    told = {note.number: note for _, note in heard}
    came = {note.number: at for at, note in heard}
    scans, bench = recording.scans(), recording.scenario.bench_scans
    found: list[Ask] = []
    for at, asked in published(recording, ASKED, UINT32):
        number = int(asked.data)
        said = told.get(number)
        if _just_started(recording, at):
            continue
        newest = _newest(recording, at, said)
        sent = bench[newest] if bench and newest >= 0 else None
        found.append(
            Ask(
                at=at,
                answered=said is not None,
                success=said is not None and said.success,
                message=said.message if said else "",
                scan=scans[newest] if newest >= 0 else None,
                label=sent.label if sent else "",
                tags=sent.tags if sent else (),
                until=came.get(number, at),
            )
        )
    if not found:
        fail("the scenario ended before anybody asked", recording=recording)
    return found


def _just_started(recording: Recording, at: float) -> bool:
    """Tell whether, in real time, one of the student's programs started shortly before this.

    A process takes time to start, and DDS to discover it: a request meanwhile reaches nobody.
    """
    starts = [program.start for program in recording.scenario.program if not program.supplied]
    late = [start for start in starts if start > 0.0]
    return recording.live is not None and any(0.0 < at - start < START_UP for start in late)


def _newest(recording: Recording, at: float, said: Answered | None) -> int:
    """Return which scan was the server's newest when it was asked; -1: it had none.

    In real time a scan that was sent at nearly the same moment may have arrived before the request
    or after it. If the answer is right for one of the candidates, it was that one.
    """
    scans = recording.scans()
    newest = sum(scan.t <= at for scan in scans) - 1
    if recording.live is None or said is None:
        return newest
    near = UNDER_WAY + recording.slack
    choices = [newest]
    if newest >= 0 and at - scans[newest].t <= near:
        choices.append(newest - 1)
    if newest + 1 < len(scans) and scans[newest + 1].t - at <= near:
        choices.append(newest + 1)
    if len(choices) == 1:
        return newest
    return next((i for i in choices if _fits(recording, i, at, said)), newest)


def _fits(recording: Recording, number: int, at: float, said: Answered) -> bool:
    """Tell whether an answer is about this scan (-1: none), or is a refusal that it allows."""
    scan = recording.scans()[number] if number >= 0 else None
    if not said.success:
        return allowed(scan, at).refusal
    try:
        stamp = float(parsed(said.message)["stamp"])
    except (ValueError, TypeError, KeyError, OverflowError, RecursionError):
        return False
    return scan is not None and abs(stamp - recording.epoch / 1e9 - scan.stamp) <= STAMP_TOLERANCE


def require_answered(recording: Recording, ask: Ask) -> None:
    """Fail if the server left a request without an answer."""
    if not ask.answered:
        fail(
            f"no answer came: {ask.what}",
            expected="a response to every request",
            actual="nothing",
            at=ask.at,
            recording=recording,
            help="The service has to be there from the constructor on, and its callback has to "
            "return the response, whatever happens in it.",
        )


def require_success(recording: Recording, ask: Ask) -> None:
    """Fail unless the server answered with a detection."""
    require_answered(recording, ask)
    if not ask.success:
        fail(
            f"{ask.what}, the server refused to answer",
            expected="success = true: the scan is fresh, and no sector is blind",
            actual=f"success = false, “{ask.message}”",
            at=ask.at,
            recording=recording,
            help="The message is a detection, and success is not: it takes the bool True; a text "
            "or a NumPy bool is garbage."
            if ask.message.lstrip().startswith("{")
            else _advice(recording),
        )


def _advice(recording: Recording) -> str:
    """Return what to look at when a server refuses that should not."""
    scenario = recording.scenario
    told = [p.arguments for p in scenario.program if p.file == "detection_server.py"]
    if not scenario.node.parameters and not any(told):
        return "Started without parameters: model_path is detection_model.pkl then."
    return "Set response.success, and refuse only for the reasons on the task's list."


def require_refusal(recording: Recording, ask: Ask, reason: str, help: str) -> None:
    """Fail unless the server refused, and said why."""
    require_answered(recording, ask)
    if ask.success:
        fail(
            f"{ask.what}, the server claimed a detection, but {reason}",
            expected="success = false, and the reason in message",
            actual=f"success = true, {ask.message}",
            at=ask.at,
            recording=recording,
            help=help,
        )
    if not ask.message.strip():
        fail(
            f"{ask.what}, the server refused without a reason",
            expected=f"a reason in message, such as “{reason}”",
            actual="an empty message",
            at=ask.at,
            recording=recording,
            help="Set response.message, too: somebody will have to find out what is wrong.",
        )


def require_contract(
    recording: Recording,
    help: str = "",
    judged: Iterable[Ask] | None = None,
    features: Callable[[Recording, Ask, str], None] | None = None,
) -> None:
    """Fail unless every answer is right: a detection of the newest scan, or a refusal.

    `judged`: the answers, read in another way; `features`: how the features are judged.
    """
    require_alive(recording)
    judged = asks(recording) if judged is None else tuple(judged)
    for ask in judged:
        right = allowed(ask.scan, ask.at)
        if not right.detection:
            require_refusal(recording, ask, right.reason, help)
        elif ask.success or not right.refusal:
            require_success(recording, ask)
            (features or require_features)(recording, ask, help)
    if not any(allowed(ask.scan, ask.at).detection for ask in judged):
        fail("the scenario has no scan to answer for", recording=recording)


def require_detection(recording: Recording, ask: Ask) -> None:
    """Fail unless the answer is the JSON object of the contract, about the newest scan."""
    require_success(recording, ask)
    said = read_detection(recording, ask)
    label, confidence, stamp = (said[key] for key in ("label", "confidence", "stamp"))
    if not isinstance(label, str) or not label:
        _fail_message(recording, ask, "a label that is a string", f"label = {_spell(label)}")
    if not _is_number(confidence) or not 0.0 <= confidence <= 1.0:
        _fail_message(
            recording, ask, "a confidence between 0 and 1", f"confidence = {_spell(confidence)}"
        )
    if ask.scan is None or not _is_number(stamp):
        _fail_message(recording, ask, "a stamp in seconds", f"stamp = {_spell(stamp)}")
    right = recording.epoch / 1e9 + ask.scan.stamp
    if not abs(stamp - right) <= STAMP_TOLERANCE:
        _fail_message(
            recording,
            ask,
            f"stamp = {right:.3f}, the time in the header of the newest scan",
            f"stamp = {stamp:.3f} ({stamp - right:+.3f} s)",
        )
    require_label(recording, ask)
    sure = [p for i in asked_about(recording, ask, "predict_proba") for p in i.said]
    if not any(abs(confidence - p) <= CONFIDENCE_TOLERANCE for p in sure):
        greatest = f" = {sure[-1]:.3f}" if sure else ""
        _fail_message(
            recording,
            ask,
            f"confidence{greatest}, the greatest of predict_proba",
            f"confidence = {confidence:.3f}" + ("" if sure else ", and nobody asked the model"),
        )


def require_label(recording: Recording, ask: Ask) -> None:
    """Fail unless the label is what the model predicted from the newest scan."""
    label = read_detection(recording, ask)["label"]
    said = words_of_model(recording, ask)
    if isinstance(label, str) and any(_is_same(label, word) for word in said):
        return
    _fail_message(
        recording,
        ask,
        f"label = {said[-1]!r}, what predict returned" if said else "the label that predict gives",
        f"label = {_spell(label)}" + ("" if said else ", and nobody asked predict"),
    )


def words_of_model(recording: Recording, ask: Ask, method: str = "predict") -> list[str]:
    """Return what predict returned between the newest scan and the answer to this request.

    With `predict_proba`: what it would have returned where that was called.
    """
    asked = asked_about(recording, ask, method)
    return [word for i in asked for word in i.labels or [f"{number:g}" for number in i.said]]


def asked_about(recording: Recording, ask: Ask, method: str) -> list[Inference]:
    """Return what the model was asked between the newest scan and the answer to this request."""
    if ask.scan is None:
        return []
    early = 0.0 if recording.live is None else UNDER_WAY
    return questions(recording, method, ask.scan.t - early, ask.until)


def _is_same(label: str, word: str) -> bool:
    """Tell whether a label is the model's: "3", "3.0" and "[3]" are one number."""
    if label == word:
        return True
    try:
        return float(label.strip("[]")) == float(word)
    except ValueError:
        return False


def require_features(recording: Recording, ask: Ask, help: str = "") -> None:
    """Fail unless the model was asked about the right features of the newest scan."""
    said = read_detection(recording, ask)
    given = spelt_features(said["label"]) if isinstance(said["label"], str) else None
    if given is None or ask.scan is None:
        _fail_message(
            recording, ask, "the label that the model gave", f"label = {_spell(said['label'])}"
        )
    _require_given(recording, ask, given, help)


def require_asked_features(recording: Recording, ask: Ask, help: str = "") -> None:
    """Fail unless the model was asked about the right features, whatever the server made of it."""
    words = words_of_model(recording, ask) or words_of_model(recording, ask, "predict_proba")
    spelt = [spelt_features(word) for word in words]
    found = [given for given in spelt if given is not None]
    if not found:
        _fail_message(recording, ask, "a question to the model about the newest scan", "none")
    for given in found:
        _require_given(recording, ask, given, help)


def _require_given(recording: Recording, ask: Ask, given: Floats, help: str) -> None:
    """Fail unless these features are those of the newest scan."""
    if ask.scan is None:
        fail(f"{ask.what}, there was nothing to ask the model about", recording=recording)
    right = possible_features(ask.scan)
    right = right[np.isfinite(right).all(axis=1)]
    if not (np.abs(given - right).max(axis=1) <= FEATURE_TOLERANCE).any():
        fail(
            f"{ask.what}, the model was given the wrong features",
            expected=f"{spell_features(scan_features(ask.scan))} (front min, mean, std, left min, "
            "right min)",
            actual=spell_features(given),
            at=ask.at,
            recording=recording,
            help=help or "They are the features of exercise 2; compare sector by sector.",
        )


def parsed(message: str) -> Any:
    """Return what a message says as JSON; a ValueError or a RecursionError if it is none."""
    if len(message) > LONGEST:  # many checks read it, and millions of brackets take long
        raise ValueError(f"{len(message):,} characters, more than {LONGEST:,}")
    return json.loads(message)


def read_detection(recording: Recording, ask: Ask) -> dict[str, Any]:
    """Return the JSON object in an answer; fail if it is none, or lacks a key."""
    try:
        said = parsed(ask.message)
    except (ValueError, RecursionError) as error:  # thousands of nested brackets, for example
        _fail_message(recording, ask, "a JSON object in message", f"no JSON: {error}")
    keys = ("label", "confidence", "stamp")
    if not isinstance(said, dict) or any(key not in said for key in keys):
        _fail_message(recording, ask, "an object with label, confidence and stamp", "another one")
    return said


def _fail_message(recording: Recording, ask: Ask, expected: str, actual: str) -> NoReturn:
    fail(
        f"{ask.what}, the server's message is not right",
        expected=expected,
        actual=f"{actual}; message = {ask.message[:200]}",
        at=ask.at,
        recording=recording,
        help="json.dumps({'label': str(…), 'confidence': float(…), 'stamp': …}) of the newest scan",
    )


def _is_number(value: Any) -> bool:
    """Tell whether a value from JSON is a number that a float can hold."""
    try:
        return not isinstance(value, bool | str) and math.isfinite(float(value))
    except (TypeError, ValueError, OverflowError):  # 1 with 400 zeros is an int, and no float
        return False


def _spell(value: Any) -> str:
    """Return a value from JSON in brief; lists and objects may be nested a thousand deep."""
    return f"a {type(value).__name__}" if isinstance(value, list | dict) else repr(value)[:80]
