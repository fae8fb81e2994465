"""What the student's clients asked and published, and their heartbeats."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from grader.checks.reading import published
from grader.checks.verdict import fail
from grader.checks.wiring import require_alive, require_wiring
from grader.exercises.model_server.contract import (
    HEARTBEAT_PERIOD,
    LONGEST_GAP,
    NEXT_REQUEST,
    ROLES,
    Floats,
)
from grader.exercises.model_server.notes import (
    SERVED,
    Answered,
    Asked,
    fail_forged,
    notes,
)
from grader.recording import Recording
from sim.messages import STRING, UINT32

DEFAULT_ROLE = ROLES[0]
HEARTBEAT_DRIFT = 0.08  # share by which the mean of the gaps may differ
TICK = 1e-6  # [s] of rounding
BLOCKED = (
    "Does a callback wait: client.call(), await in the default callback group, "
    "spin_until_future_complete(), a sleep, a loop? While it waits, its executor delivers nothing, "
    "not even the answer that it waits for. Use call_async() and future.add_done_callback(), and "
    "return. Or is the heartbeat skipped while a request is open?"
)


@dataclass(frozen=True)
class Request:
    """A request that reached the grader's server, and its answer."""

    number: int  # as the server counts
    at: float  # [s]
    answered: float  # [s]; inf: never
    success: bool = False
    message: str = ""


def roles(recording: Recording) -> list[str]:
    """Return the roles of the clients in the scenario."""
    words = {word for program in recording.scenario.program for word in program.arguments}
    found = [role for role in ROLES if f"role:={role}" in words]
    return found or [DEFAULT_ROLE]


def requests(recording: Recording) -> list[Request]:
    """Return the requests that reached the grader's server, in order."""
    found: list[Request] = []
    places: dict[tuple[int, int], int] = {}  # life of a server, number of a request: its place
    for at, note in notes(recording, SERVED):
        key = (note.life, note.number)
        if isinstance(note, Asked):
            places[key] = len(found)
            found.append(Request(note.number, at, math.inf))
        elif key in places:
            asked = found[places[key]].at
            found[places[key]] = Request(note.number, asked, at, note.success, note.message)
        elif recording.live is None:  # in real time clients also ask before the recording begins
            fail_forged(recording, SERVED, at)
    return found


def successes(recording: Recording) -> set[str]:
    """Return the messages that the server sent with success, even if the request was not noted."""
    said = (note for _, note in notes(recording, SERVED))
    return {note.message for note in said if isinstance(note, Answered) and note.success}


def detections(recording: Recording) -> list[tuple[float, str, str]]:
    """Return what the clients published on their detection topics: time [s], role, text."""
    found = []
    for role in roles(recording):
        said = published(recording, f"/{role}/detection", STRING)
        found += [(time, role, str(value.data)) for time, value in said]
    return sorted(found)


def beats(recording: Recording, role: str) -> tuple[Floats, list[int]]:
    """Return the times [s] and values of a client's heartbeats."""
    heard = published(recording, f"/{role}/heartbeat", UINT32)
    return np.array([t for t, _ in heard], dtype=float), [int(value.data) for _, value in heard]


def require_unblocked(recording: Recording) -> None:
    """Fail if a client's heartbeat paused: then one of its callbacks blocks. Or if nobody asked."""
    require_alive(recording)
    for role in roles(recording):
        times, _ = beats(recording, role)
        if len(times) < 2:
            continue  # no heartbeat that could pause: another check's matter
        gaps = np.diff([*times, recording.duration_s])
        longest = int(np.argmax(gaps))
        if gaps[longest] <= max(LONGEST_GAP + recording.slack, 2 * gaps[:-1].min()) + TICK:
            continue
        at = float(times[longest])
        out = [r for r in requests(recording) if at - TICK <= r.at <= at + LONGEST_GAP]
        for_good = longest == len(gaps) - 1
        fail(
            f"{role}_client stood still "
            + (f"for good from {at:.2f} s on" if for_good else f"for {gaps[longest]:.2f} s"),
            expected=f"a heartbeat at least every {LONGEST_GAP} s, whatever the server does",
            actual=f"none after {at:.2f} s"
            + (f"; it had asked /detect at {out[0].at:.2f} s" if out else ""),
            at=at,
            recording=recording,
            help=BLOCKED,
        )
    if not requests(recording):
        fail(
            "no client ever asks, so there is no answer to wait for",
            expected="a request every 0.5 s, and heartbeats meanwhile",
            actual="no request",
            at=NEXT_REQUEST,
            recording=recording,
            help="Does a timer ask, and is its callback called? Is the service looked for anew?",
        )


def require_own_topics(recording: Recording) -> None:
    """Fail unless each role publishes on its own topics, and on no other's."""
    for end in recording.endpoints:
        role = end.node.strip("/").removesuffix("_client")
        other = end.topic.strip("/").partition("/")[0]
        if role in ROLES and end.kind == "publisher" and other in ROLES and other != role:
            fail(
                f"{role}_client publishes on {end.topic}",
                expected=f"topics of its role: /{role}/…",
                actual=f"a publisher on {end.topic}",
                recording=recording,
                help="Read the parameter: self.declare_parameter('role', …).value",
            )
    require_wiring(recording, "model_server", *(f"{role}_client" for role in roles(recording)))


def require_heartbeat(recording: Recording, until: float = math.inf) -> None:
    """Fail unless each client's heartbeat comes ten times a second, start to end, and counts up.

    Pauses that begin after `until` [s] are not judged.
    """
    require_alive(recording)
    for role in roles(recording):
        topic = f"/{role}/heartbeat"
        times, values = beats(recording, role)
        bounds = np.array([0.0, *times, recording.duration_s])
        gaps = np.diff(bounds)
        judged = bounds[:-1] < until - LONGEST_GAP
        long = np.flatnonzero((gaps > LONGEST_GAP + recording.slack + TICK) & judged)
        if len(long):
            at = float(bounds[long[0]])
            fail(
                f"the heartbeat of {role}_client pauses for {gaps[long[0]]:.2f} s"
                if len(times)
                else f"{role}_client has no heartbeat",
                expected=f"a message on {topic} every 0.1 s, gaps of at most {LONGEST_GAP} s, with "
                "or without a server",
                actual=f"none from {at:.2f} s to {at + gaps[long[0]]:.2f} s",
                at=at,
                recording=recording,
                help="Give it a timer of its own that waits for nothing. Does the constructor or "
                "a callback wait for the service (wait_for_service)?",
            )
        if gaps[1:-1].min(initial=math.inf) < LONGEST_GAP / 3 - recording.slack:
            at = float(times[int(np.argmin(gaps[1:-1]))])
            fail(
                f"two heartbeats of {role}_client are only {gaps[1:-1].min():.3f} s apart",
                expected=f"one message on {topic} every 0.1 s",
                actual=f"{len(times)} in {recording.duration_s:.1f} s",
                at=at,
                recording=recording,
                help="One timer of 0.1 s publishes it, and nothing else does.",
            )
        if math.isinf(until):
            _require_rate(recording, role, times)
        for index, (before, after) in enumerate(pairwise(values)):
            if after != before + 1:
                fail(
                    f"the heartbeat of {role}_client does not count up",
                    expected=f"{before + 1} after {before}",
                    actual=str(after),
                    at=float(times[index + 1]),
                    recording=recording,
                    help="Keep the count in an attribute of the node, and add 1 each time.",
                )


def _require_rate(recording: Recording, role: str, times: Floats) -> None:
    """Fail unless a client's heartbeats, at these times [s], are 0.1 s apart on average."""
    mean = float(np.diff(times).mean()) if len(times) > 1 else HEARTBEAT_PERIOD
    if abs(mean - HEARTBEAT_PERIOD) <= HEARTBEAT_DRIFT * HEARTBEAT_PERIOD + recording.slack:
        return
    fail(
        f"the heartbeats of {role}_client are {mean:.3f} s apart on average",
        expected=f"one message on /{role}/heartbeat every {HEARTBEAT_PERIOD} s",
        actual=f"{len(times)} in {recording.duration_s:.1f} s",
        at=float(times[1]),
        recording=recording,
        help="self.create_timer(0.1, …)",
    )


def warnings(recording: Recording, begin: float, end: float) -> bool:
    """Tell whether the clients logged a warning (or worse) in this time [s]."""
    return any(
        line.level in ("warn", "error", "fatal") and begin - TICK <= line.t <= end + TICK
        for line in recording.log
    )
