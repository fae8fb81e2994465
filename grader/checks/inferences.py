"""What the models that the judge keeps were asked: the evidence of time, loads and calls."""

from __future__ import annotations

from grader.recording import Inference, Recording


def questions(recording: Recording, method: str, since: float, until: float) -> list[Inference]:
    """Return what a model was asked and had answered between two times [s].

    In real time what happened shortly before or after counts, too.
    """
    begin, end = since - recording.slack, until + recording.slack
    return [
        i
        for i in recording.inferences
        if i.method == method and begin <= i.asked / 1e9 and i.answered / 1e9 <= end
    ]


def loads(recording: Recording) -> list[Inference]:
    """Return each load of a model."""
    return [inference for inference in recording.inferences if inference.is_load]
