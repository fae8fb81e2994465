"""What the grader's own programs, which run beside the student's, noted for the judge."""

from __future__ import annotations

import json
from typing import Any

from grader.recording import Recording
from grader.verdict import fail
from sim.messages import STRING, decode

ASKED, TOLD = "/probe/asked", "/probe/told"  # of grader/host/supplied/detection_asker.py
REQUESTS, ANSWERS = "/probe/requests", "/probe/answers"  # of detection_double.py


def notes(recording: Recording, topic: str) -> list[tuple[float, dict[str, Any]]]:
    """Return what a program of the grader's noted on a topic: time [s] and JSON object."""
    ends = [e for e in recording.endpoints if e.topic == topic and e.kind == "publisher"]
    if len(ends) > sum(program.supplied for program in recording.scenario.program):
        fail(
            f"{topic} is a topic of the grader's, and one of your nodes publishes on it",
            expected="only the topics of the exercise",
            actual=", ".join(end.node for end in ends),
            recording=recording,
            help="Choose another name for your topic.",
        )
    return [
        (message.time / 1e9, json.loads(decode(message.data, STRING).data))
        for message in recording.of(topic)
        if message.type == STRING
    ]
