"""What the grader's own programs, which run beside the student's, noted for the judge.

In virtual time they share a process with the student's nodes, in real time a user account. So a
student's node could forge their notes, and they are read with that in mind.
"""

from __future__ import annotations

from typing import NoReturn

import msgspec

from grader.checks.commands import published
from grader.checks.verdict import fail
from grader.recording import Recording
from sim.messages import STRING

ASKED, TOLD = "/probe/asked", "/probe/told"  # of grader/host/supplied/detection_asker.py
SERVED = "/probe/served"  # of detection_double.py
START_UP = 1.0  # [s] a program takes, in real time, to start and to be discovered
NEAR = 0.051  # [s] ages and waits within 50 ms of a limit may fall on either side


class Asked(msgspec.Struct, frozen=True, tag="asked"):
    """A request came in."""

    number: int
    life: int = 0  # of the server that was asked
    kind: str = ""  # of the answer that it will get: fine, never, half, …


class Answered(msgspec.Struct, frozen=True, tag="answered"):
    """A request was answered."""

    number: int
    success: bool
    message: str
    life: int = 0


def notes(recording: Recording, topic: str) -> list[tuple[float, Asked | Answered]]:
    """Return the notes of a grader's program on a topic: time [s] and note."""
    require_ours(recording, topic)
    found = []
    for at, value in published(recording, topic, STRING):
        try:
            found.append((at, msgspec.json.decode(value.data, type=Asked | Answered)))
        except (msgspec.MsgspecError, ValueError, RecursionError):
            fail_forged(recording, topic, at)
    return found


def require_ours(recording: Recording, topic: str) -> None:
    """Fail if any other than the grader's programs publishes on a topic of theirs."""
    ends = [e for e in recording.endpoints if e.topic == topic and e.kind == "publisher"]
    if len(ends) > sum(program.supplied for program in recording.scenario.program):
        fail_forged(recording, topic, None)


def fail_forged(recording: Recording, topic: str, at: float | None) -> NoReturn:
    """Fail: something on a topic of the grader's does not come from the grader."""
    ends = [e.node for e in recording.endpoints if e.topic == topic and e.kind == "publisher"]
    fail(
        f"{topic} is a topic of the grader's, and one of your nodes publishes on it",
        expected="only the topics of the exercise",
        actual=", ".join(ends) or "a message that is not the grader's",
        at=at,
        recording=recording,
        help="Choose another name for your topic.",
    )
