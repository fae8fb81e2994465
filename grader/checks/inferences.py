"""What the models that the judge keeps were asked: the evidence of time, loads and calls."""

from __future__ import annotations

from itertools import pairwise

from grader.checks.verdict import fail
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


def require_one_load(recording: Recording, until: float) -> None:
    """Fail unless the model was loaded once by `until` [s], while the node was constructed."""
    found = [load for load in loads(recording) if load.asked / 1e9 <= until]
    first = min((scan.t for scan in recording.scans()), default=until)  # none: it died before
    if len(found) == 1 and found[0].asked / 1e9 < first:
        return
    late = len(found) == 1
    fail(
        f"the model was loaded at {found[0].asked / 1e9:.3f} s, after the first scan had come"
        if late
        else f"{len(found) or 'no'} loads of the model by the scan at {until:.3f} s",
        expected="1 load, while the node is constructed",
        actual=f"a load at {found[0].asked / 1e9:.3f} s" if late else f"{len(found)} loads",
        at=until,
        recording=recording,
        help="Unpickle in __init__, keep the model in an attribute, use it in the callback.",
    )


def require_kept(recording: Recording, after: str = "after the model had failed") -> None:
    """Fail if the model was loaded again; `after` says in words what may have led to it."""
    found = [load.asked / 1e9 for load in loads(recording)]
    if len(found) > 1:
        fail(
            f"at {found[1]:.2f} s, {after}, it was loaded again",
            expected="1 load, while the node is constructed",
            actual=f"{len(found)} loads",
            at=found[1],
            recording=recording,
            help="The model in memory is still the same one: ask it again, do not load it again.",
        )


def require_one_at_a_time(recording: Recording) -> None:
    """Fail if predict was called while another call of it still ran."""
    calls = [i for i in recording.inferences if i.method == "predict" and i.asked >= 0]
    for before, after in pairwise(sorted(calls, key=lambda call: call.asked)):
        if after.asked < before.answered:
            fail(
                "two inferences ran at the same time",
                expected="the next one starts when the last one has ended",
                actual=f"predict was called at {after.asked / 1e9:.3f} s, while the call of "
                f"{before.asked / 1e9:.3f} s still ran",
                at=after.asked / 1e9,
                recording=recording,
                help="A MutuallyExclusiveCallbackGroup, or a single worker thread, ensures that.",
            )
