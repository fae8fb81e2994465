"""What the grader's own programs, which run beside the student's, noted for the judge.

In virtual time they share a process with the student's nodes, in real time a user account. So a
student's node could forge their notes, and they are read with that in mind.
"""

from __future__ import annotations

from contextlib import suppress

import msgspec

from grader.checks.commands import published
from grader.checks.verdict import fail
from grader.recording import Recording
from sim.messages import STRING

ASKED, TOLD = "/probe/asked", "/probe/told"  # of grader/host/supplied/detection_asker.py
SERVED = "/probe/served"  # of detection_double.py
START_UP = 1.0  # [s] a program takes, in real time, to start and to be discovered
NEAR = 0.051  # [s] ages and waits within 50 ms of a limit may fall on either side


class Note(msgspec.Struct, frozen=True):
    """A request came in, or was answered."""

    type: str  # asked or answered
    number: int
    life: int = 0  # of the server that was asked
    kind: str = ""  # of the answer that a request will get: fine, never, half, …
    success: bool = False
    message: str = ""


def notes(recording: Recording, topic: str) -> list[tuple[float, Note]]:
    """Return the notes of a grader's program on a topic: time [s] and note."""
    require_ours(recording, topic)
    found = []
    for at, value in published(recording, topic, STRING):
        with suppress(ValueError, RecursionError):
            found.append((at, msgspec.json.decode(value.data, type=Note)))
    return found


def require_ours(recording: Recording, topic: str) -> None:
    """Fail if any other than the grader's programs publishes on a topic of theirs."""
    ends = [e for e in recording.endpoints if e.topic == topic and e.kind == "publisher"]
    if len(ends) > sum(program.supplied for program in recording.scenario.program):
        fail(
            f"{topic} is a topic of the grader's, and one of your nodes publishes on it",
            expected="only the topics of the exercise",
            actual=", ".join(end.node for end in ends),
            at=0.0,
            recording=recording,
            help="Choose another name for your topic.",
        )
