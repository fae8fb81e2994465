"""What the student's clients have to do beside the grader's server: ask, publish, and beat.

found       a server has started: the first request comes
rhythm      a request was answered soon: the next comes 0.5 s after it
patience    of one client: the next request waits for the answer, but not for ever
owed        the same, where there was no answer in time
publish     the server said something with success: that is published, and nothing else
beats       each heartbeat counts up, and their mean period is 0.1 s
goes_on     a client asks, and its heartbeat never pauses: no callback waits
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise, zip_longest

import numpy as np

from grader.checks.case import Case, exactly
from grader.checks.commands import published
from grader.checks.words import every, logs
from grader.exercises.model_server.notes import (
    NEAR,
    SERVED,
    START_UP,
    Answered,
    Asked,
    fail_forged,
    notes,
)
from grader.recording import Recording
from sim.messages import STRING, UINT32

ROLES = ("navigation", "manipulation", "logging")
DOUBLE = "detection_double.py"
ASK_PERIOD = 0.5  # [s] from one request to the next
PATIENCE = 1.0  # [s] after a request: if there is no answer, it is given up ...
NEXT_REQUEST = 1.5  # [s] ... and the next goes out by this time
PUBLISHED_WITHIN = ASK_PERIOD + 0.1  # [s] after the answer; some look for it at their next tick
BEAT = 0.1  # [s] from one heartbeat to the next
BEAT_DRIFT = 0.008  # [s] by which the mean may differ
LONGEST_GAP = 0.15  # [s] between two heartbeats
TICK = 1e-6  # [s] of rounding
QUOTED = 200  # characters of a message
WELL_FORMED = ("fine", "same")  # kinds of answers
WARNINGS = ("warn", "error", "fatal")
WAIT, FIRST = "seconds to the next request", "seconds to the first request"
MEAN, PAUSE = "seconds from one to the next, on average", "seconds to the next"


@dataclass(frozen=True)
class Request:
    """A request that reached the grader's server, and its answer."""

    at: float  # [s]
    kind: str = ""  # of the answer
    answered: float = math.inf  # [s]; inf: never
    success: bool = False
    message: str = ""

    @property
    def took(self) -> float:
        """How long the answer took [s]."""
        return self.answered - self.at


def roles(recording: Recording) -> list[str]:
    """Return the roles of the clients in the scenario."""
    words = {word for program in recording.scenario.program for word in program.arguments}
    return [role for role in ROLES if f"role:={role}" in words] or [ROLES[0]]


def requests(recording: Recording) -> list[Request]:
    """Return the requests that reached the grader's server, in order."""
    found: dict[tuple[int, int], Request] = {}  # by life of a server, and number
    for at, note in notes(recording, SERVED):
        key = note.life, note.number
        if isinstance(note, Asked):
            found[key] = Request(at, note.kind)
        elif key in found:
            asked = found[key]
            found[key] = Request(asked.at, asked.kind, at, note.success, note.message)
        elif recording.live is None:  # in real time clients also ask before the recording begins
            fail_forged(recording, SERVED, at)
    return list(found.values())


def cases(recording: Recording) -> Iterator[Case]:
    """Yield the occasions of the clients' heartbeats, and of the grader's server if it is there."""
    for role in roles(recording):
        yield from _heartbeats(recording, role)
    if not any(program.file == DOUBLE for program in recording.scenario.program):
        return
    asked = requests(recording)
    some = {"requests": "some" if asked else "none"}
    what, some_are = "a client runs beside the server", {"requests": frozenset({"some"})}
    yield Case(NEXT_REQUEST, what, frozenset({"goes_on"}), some_are, some)
    yield from _first_requests(recording, asked)
    if len(roles(recording)) == 1:
        yield from _next_requests(recording, asked)
    yield from _publications(recording, asked)


def _first_requests(recording: Recording, asked: list[Request]) -> Iterator[Case]:
    latest = NEXT_REQUEST + NEAR + recording.slack + START_UP * (recording.live is not None)
    for life in recording.scenario.program:
        end = life.stop or recording.duration_s
        if life.file != DOUBLE or (recording.live is not None and end - life.start < latest):
            continue
        after = (request.at - life.start for request in asked if life.start <= request.at <= end)
        yield Case(
            at=life.start,
            what=f"a server starts at {life.start:.2f} s",
            tags=frozenset({"found"}),
            allowed={FIRST: ((0.0, latest),)},
            said={FIRST: min(after, default=math.inf)},
        )


def _next_requests(recording: Recording, asked: list[Request]) -> Iterator[Case]:
    near = NEAR + recording.slack
    for request, after in zip_longest(asked, asked[1:]):
        wait = (after.at if after else recording.duration_s) - request.at
        if not after and wait <= NEXT_REQUEST + near:
            return
        answered = f"answered after {request.took:.2f} s"
        case = Case(
            at=request.at,
            what=f"a request, {answered if math.isfinite(request.took) else 'never answered'}",
            tags=frozenset({"patience", *(["owed"] if request.took > PATIENCE else [])}),
            allowed={WAIT: ((min(request.took, PATIENCE - near), NEXT_REQUEST + near),)},
            said={WAIT: wait},
        )
        yield case
        if request.took < ASK_PERIOD - near:
            soon = {WAIT: ((ASK_PERIOD - near, ASK_PERIOD + near),)}
            yield replace(case, tags=frozenset({"rhythm"}), allowed=soon)


def _publications(recording: Recording, asked: list[Request]) -> Iterator[Case]:
    heard = sorted(
        (time, str(value.data))
        for role in roles(recording)
        for time, value in published(recording, f"/{role}/detection", STRING)
    )
    last = recording.duration_s - PUBLISHED_WITHIN
    for before, request in pairwise([Request(0.0, "first"), *asked]):
        late = request.took > PATIENCE - NEAR or request.answered >= last
        if late or request.kind not in WELL_FORMED:
            continue
        end = request.answered + PUBLISHED_WITHIN
        texts = [text for time, text in heard if request.answered <= time <= end]
        other = texts[-1][:QUOTED] if texts else "nothing"
        yield Case(
            at=request.answered,
            what=f"the server answered (before: {before.kind})",
            tags=frozenset({"publish"}),
            allowed={"data": frozenset({request.message})},
            said={"data": request.message if request.message in texts else other},
        )
    said = (note for _, note in notes(recording, SERVED) if isinstance(note, Answered))
    sent = Counter(note.message for note in said if note.success)
    for time, text in heard:
        sent[text] -= 1
        if sent[text] < 0:
            yield Case(
                at=time,
                what=f"“{text[:QUOTED]}” is no answer with success, or was published before",
                tags=frozenset({"publish"}),
            )


def _heartbeats(recording: Recording, role: str) -> Iterator[Case]:
    heard = published(recording, f"/{role}/heartbeat", UINT32)
    gaps = np.diff([*(time for time, _ in heard), recording.duration_s])
    if len(heard) < 2:
        return
    beats, what = frozenset({"beats"}), f"a heartbeat of {role}_client"
    near = BEAT_DRIFT + recording.slack
    mean, apart = float(gaps[:-1].mean()), {MEAN: ((BEAT - near, BEAT + near),)}
    yield Case(heard[0][0], f"the heartbeats of {role}_client", beats, apart, {MEAN: mean})
    for (_, before), (at, after) in pairwise(heard):
        yield Case(at, what, beats, {"data": exactly(before.data + 1)}, {"data": after.data})
    # one that is slow all the time does not wait
    right = {PAUSE: ((0.0, max(LONGEST_GAP + recording.slack, 2 * gaps[:-1].min()) + TICK),)}
    for (at, _), gap in zip(heard, gaps.tolist(), strict=True):
        yield Case(at, what, frozenset({"goes_on"}), right, {PAUSE: gap})


def beats(recording: Recording) -> None:
    """Fail unless each client's heartbeat comes ten times a second."""
    for role in roles(recording):
        help = (
            "Give it a timer of 0.1 s that waits for nothing. Does the constructor, or a "
            "callback, wait for the service (wait_for_service)?"
        )
        every(recording, f"/{role}/heartbeat", BEAT, LONGEST_GAP - BEAT + TICK, help=help)


def warns(recording: Recording, since: float) -> None:
    """Fail unless a warning follows each request that was never answered, `since` [s] after it."""
    for request in requests(recording):
        end = request.at + NEXT_REQUEST + NEAR + recording.slack
        if math.isinf(request.answered) and end < recording.duration_s:
            begin = request.at + since - recording.slack
            what = "a request is given up"
            logs(recording, WARNINGS, what=what, begin=begin, end=end)
