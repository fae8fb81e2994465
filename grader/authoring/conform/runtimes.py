"""The same solutions on the real rclpy and on the portable runtime: same messages, same verdicts?

What a recording holds is compared by its digest, which re-encodes every message. Two things are
left out of it: the order of messages of different topics at one moment, which means nothing, and
how long a training took. What a trained model says is compared to a nanometre per second: a forest
that predicts in several threads adds its trees up in the order in which they end.
"""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from fnmatch import fnmatchcase

import numpy as np
from msgspec import structs

from grader.authoring.claims import Claim, claims, grade_claim
from grader.authoring.proof import objections
from grader.course.exercises import Exercise
from grader.errors import GraderError
from grader.grading.grading import Grading
from grader.link.hosts import ForkServer
from grader.link.ros_environment import find_ros, portable_ros
from grader.recording import Recording
from grader.recording.training import ModelAnswers
from sim.messages import EPOCH_NS

AS_REAL, OTHER, ABSENT = "as the real one", "differs", "absent"
VERDICT = "verdict"  # in the place of a scenario's name


@dataclass
class Compared:
    """How the portable runtime compares: by `exercise/kind/solution/scenario`, or `…/verdict`."""

    outcomes: dict[str, str] = field(default_factory=dict)
    texts: dict[str, str] = field(default_factory=dict)  # in what they differ
    seconds: dict[str, float] = field(default_factory=lambda: {"real": 0.0, "portable": 0.0})

    @property
    def expected(self) -> dict[str, str]:
        """How the real one compares with itself."""
        return dict.fromkeys(self.outcomes, AS_REAL)


def compare(exercise: Exercise, patterns: Iterable[str], compared: Compared) -> Iterator[str]:
    """Grade the solutions of an exercise whose names fit on both runtimes; yield a line for each.

    Parameters
    ----------
    patterns
        Of names, such as `*/variant/compact/*`; none: all.
    """
    wanted = list(patterns) or ["*"]
    with (
        ForkServer(EPOCH_NS, find_ros(), libraries=exercise.libraries) as real,
        ForkServer(EPOCH_NS, portable_ros(), libraries=exercise.libraries) as portable,
    ):
        for claim in claims(exercise):
            if claim.lacks or not any(fnmatchcase(claim.name, pattern) for pattern in wanted):
                continue
            both = {
                name: _graded(claim, server, compared.seconds)
                for name, server in (("real", real), ("portable", portable))
            }
            found = _differences(claim, both["real"], both["portable"])
            for place, text in found.items():
                name = f"{claim.name}/{place}"
                compared.outcomes[name] = OTHER if text else AS_REAL
                if text:
                    compared.texts[name] = text
            differ = [place for place, text in found.items() if text]
            yield f"{claim.name}: {len(found) - 1} trials, {', '.join(differ) or 'all equal'}"


def _graded(claim: Claim, server: ForkServer, seconds: dict[str, float]) -> Grading | str:
    """Grade a solution; return what went wrong if it can't be."""
    kind = "portable" if server.ros.kind == "portable" else "real"
    begun = time.perf_counter()
    try:
        return grade_claim(claim, server)
    except GraderError as error:
        return str(error)
    finally:
        seconds[kind] += time.perf_counter() - begun


def _differences(claim: Claim, real: Grading | str, portable: Grading | str) -> dict[str, str]:
    """Return in what two gradings differ, by scenario, and in their verdict; "": in nothing."""
    if isinstance(real, str) or isinstance(portable, str):
        return {VERDICT: "" if real == portable else f"real: {real}; portable: {portable}"[:300]}
    ours = {recording.name: recording for recording in portable.recordings}
    found = {
        recording.name: _difference(recording, ours.get(recording.name))
        for recording in real.recordings
    }
    verdicts = [_verdict(claim, grading) for grading in (real, portable)]
    found[VERDICT] = "" if verdicts[0] == verdicts[1] else f"{verdicts[0]} / {verdicts[1]}"
    return found


def _verdict(claim: Claim, grading: Grading) -> list[str]:
    """Return what a grading comes to: the outcome of each check, and objections to the claim."""
    said = [f"{check.id}: {check.outcome}" for check in grading.checks]
    return [f"{grading.score} points", *said, *objections(claim, grading)]


def _difference(real: Recording, portable: Recording | None) -> str:
    if portable is None:
        return ABSENT
    a, b = comparable(real), comparable(portable)
    if a.digest() == b.digest():
        return ""
    if (a.outcome.kind, a.outcome.text) != (b.outcome.kind, b.outcome.text):
        return f"{a.outcome.kind} ({a.outcome.text}) / {b.outcome.kind} ({b.outcome.text})"
    if a.endpoints != b.endpoints:
        return f"endpoints: {sorted(map(str, set(a.endpoints) ^ set(b.endpoints)))}"
    for mine, theirs in zip(a.published, b.published, strict=False):
        if mine != theirs:
            return (
                f"{mine.time} {mine.topic} {mine.data.hex()[:120]} / "
                f"{theirs.time} {theirs.topic} {theirs.data.hex()[:120]}"
            )
    counts = f"{len(a.published)} / {len(b.published)} messages"
    return f"{counts}, ended at {a.outcome.at} / {b.outcome.at}"


def comparable(recording: Recording) -> Recording:
    """Return a recording without what may differ between two runs."""
    published = tuple(sorted(recording.published, key=lambda m: (m.time, m.topic)))
    outcome = recording.outcome
    training = recording.training
    if training is not None or recording.live is not None:
        outcome = replace(outcome, at=0.0)  # in wall-clock time
    if training is not None:
        training = structs.replace(
            training,
            pickle=_rounded(training.pickle),
            again=_rounded(training.again),
            onnx=_rounded(training.onnx),
        )
    return replace(recording, published=published, outcome=outcome, training=training)


def _rounded(answers: ModelAnswers) -> ModelAnswers:
    return structs.replace(answers, values=np.round(answers.speeds, 9).tobytes())
