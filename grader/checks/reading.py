"""Read what a node published. The bytes may be anything: what can't be read fails the check."""

from __future__ import annotations

from typing import Any

from grader.checks.verdict import fail
from grader.recording import Recording
from sim.messages import decode


def published(recording: Recording, topic: str, type: str) -> list[tuple[float, Any]]:
    """Return time [s] and value of each message of a type that the node published on a topic."""
    found = []
    for message in recording.published:
        if message.topic != topic or message.type != type:
            continue
        try:
            found.append((message.time / 1e9, decode(message.data, type)))
        except ValueError as error:
            fail(
                f"a message on {topic} can't be read",
                expected=f"a {type}",
                actual=str(error)[:200],
                at=message.time / 1e9,
                recording=recording,
                help="Publish message objects, with the Python types that their fields want.",
            )
    return found
