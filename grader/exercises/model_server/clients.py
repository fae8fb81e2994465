"""What the student's clients have to do beside the grader's server: ask, publish, and beat.

found       a server has started: the first request comes
rhythm      a request was answered soon: the next comes 0.5 s after it
patience    of one client: the next request waits for the answer, but not for ever
publish     the server said something with success: that is published, and nothing else
beats       each heartbeat counts up, and their mean period is 0.1 s
goes_on     a client asks, and its heartbeat never pauses: no callback waits
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise, zip_longest

import numpy as np

from grader.checks.case import Case, exactly
from grader.checks.commands import published
from grader.checks.verbs import every, logs
from grader.exercises.model_server.notes import NEAR, START_UP, Request, requests
from grader.models.partners import DOUBLE, WELL_FORMED
from grader.recording import Recording
from sim.messages import STRING, UINT32

ROLES = ("navigation", "manipulation", "logging")
ASK_PERIOD = 0.5  # [s] from one request to the next
PATIENCE = 1.0  # [s] after a request: if there is no answer, it is given up ...
NEXT_REQUEST = 1.5  # [s] ... and the next goes out by this time
PUBLISHED_WITHIN = ASK_PERIOD + 0.1  # [s] after the answer; some look for it at their next tick
BEAT = 0.1  # [s] from one heartbeat to the next
BEAT_DRIFT = 0.008  # [s] by which the mean may differ
LONGEST_GAP = 0.15  # [s] between two heartbeats
TICK = 1e-6  # [s] of rounding
QUOTED = 200  # characters of a message
WARNINGS = ("warn", "error", "fatal")
WAIT, FIRST = "seconds to the next request", "seconds to the first request"
MEAN, PAUSE = "seconds from one to the next, on average", "seconds to the next"


def roles(recording: Recording) -> list[str]:
    """Return the roles of the clients in the scenario."""
    words = {word for program in recording.scenario.program for word in program.arguments}
    return [role for role in ROLES if f"role:={role}" in words] or [ROLES[0]]


def cases(recording: Recording) -> Iterator[Case]:
    """Yield the occasions of the clients' heartbeats, and of the grader's server if it is there."""
    clients = roles(recording)
    for role in clients:
        yield from _heartbeats(recording, role)
    lives = [each for each in recording.scenario.program if each.file == DOUBLE]
    asked, live = requests(recording) if lives else [], recording.live is not None
    latest = NEXT_REQUEST + NEAR + recording.slack + START_UP * live
    for life in lives:
        end = life.stop or recording.duration_s
        if not live or end - life.start >= latest:
            after = [each.at - life.start for each in asked if life.start <= each.at <= end]
            what, tags = f"a server starts at {life.start:.2f} s", frozenset({"found", "goes_on"})
            first = {FIRST: min(after, default=math.inf)}
            yield Case(life.start, what, tags, {FIRST: ((0.0, latest),)}, first)
    if lives and len(clients) == 1:
        yield from _next_requests(recording, asked)
    if lives:
        yield from _publications(recording, asked)


def _next_requests(recording: Recording, asked: list[Request]) -> Iterator[Case]:
    near = NEAR + recording.slack
    for request, after in zip_longest(asked, asked[1:]):
        wait = (after.at if after else recording.duration_s) - request.at
        if not after and wait <= NEXT_REQUEST + near:
            return
        what = "a request without an answer in time" if request.took > PATIENCE else "a request"
        right = {WAIT: ((min(request.took, PATIENCE - near), NEXT_REQUEST + near),)}
        case = Case(request.at, what, frozenset({"patience"}), right, {WAIT: wait})
        yield case
        if request.took < ASK_PERIOD - near:
            soon = {WAIT: ((ASK_PERIOD - near, ASK_PERIOD + near),)}
            yield replace(case, tags=frozenset({"rhythm"}), allowed=soon)


def _publications(recording: Recording, asked: list[Request]) -> Iterator[Case]:
    """Yield each good answer, which is published soon, and each message that is no such answer."""
    heard = sorted(
        (time, str(value.data))
        for role in roles(recording)
        for time, value in published(recording, f"/{role}/detection", STRING)
    )
    last, tags = recording.duration_s - PUBLISHED_WITHIN, frozenset({"publish"})
    for request in asked:
        end = request.answered + PUBLISHED_WITHIN
        late = request.took > PATIENCE - NEAR or request.answered >= last
        if request.kind in WELL_FORMED and not late:
            texts = [text for time, text in heard if request.answered <= time <= end]
            soon = request.message if request.message in texts else "".join(texts[-1:])[:QUOTED]
            right = {"data": frozenset({request.message})}
            yield Case(request.answered, "the server answered", tags, right, {"data": soon})
    sent = Counter(request.message for request in asked if request.success)
    for time, text in heard:
        sent[text] -= 1
        if sent[text] < 0:
            what = f"“{text[:QUOTED]}” is no answer with success, or was published before"
            yield Case(time, what, tags)


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
        help = "Give it a timer of 0.1 s. Does the constructor or a callback wait for the service?"
        every(recording, f"/{role}/heartbeat", BEAT, LONGEST_GAP - BEAT + TICK, help=help)


def warns(recording: Recording) -> None:
    """Fail unless a warning follows each request that was never answered."""
    for request in requests(recording):
        end = request.at + NEXT_REQUEST + NEAR + recording.slack
        if math.isinf(request.answered) and end < recording.duration_s:
            what = "a request is given up"
            logs(recording, WARNINGS, what=what, begin=request.at, end=end)
