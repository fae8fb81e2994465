"""What an agent of trend_memory is, and on which occasions it says what."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from grader.checks.case import Case, exactly
from grader.checks.commands import Answer, answers
from grader.checks.contract import Contract, Limits, Survived, free_from
from grader.checks.reading import published
from grader.exercises.trend_memory.memory import SIZE, Step, steps
from grader.recording import Recording
from sim.messages import FLOAT64

TOPIC = "/closing_speed"

CONTRACT = Contract(
    limits=Limits(fastest=0.3),
    free=free_from(0.65),
    patience=4.0,
    delayed_in=("trend_wall", "trend_cart"),
    survives=Survived(sensors=300, commands=300),
)


def cases(recording: Recording) -> list[Case]:
    """Return two occasions for each scan: its command, and its closing speed.

    The second is missing where the contract leaves open whether a closing speed comes.
    """
    found = answers(recording)
    said = published(recording, TOPIC, FLOAT64)
    begins = [*(answer.scan.t for answer in found), math.inf]
    bounds = np.searchsorted([time for time, _ in said], begins)
    occasions = []
    for i, step in enumerate(steps([answer.scan for answer in found])):
        occasions.append(_command(found[i], step))
        if step.silent or step.full:
            values = [float(value.data) for _, value in said[bounds[i] : bounds[i + 1]]]
            what = f"scan {i + 1} ({found[i].what})"
            occasions.append(_closing_speed(found[i].scan.t, what, step, values))
    return occasions


def _command(answer: Answer, step: Step) -> Case:
    what, closing = answer.what, step.closings[0]
    if closing and closing > 0.0 and step.distance is not None:
        what += f" ({step.distance / closing:.1f} s left at {closing:.2f} m/s)"
    return Case(
        at=answer.scan.t,
        what=what,
        tags=frozenset({"command", *answer.tags, *(["forgotten"] if step.forgotten else [])}),
        allowed={"linear.x": exactly(*step.speeds)},
        said=answer.said("linear.x"),
        count=answer.count,
    )


def _closing_speed(at: float, what: str, step: Step, values: Sequence[float]) -> Case:
    if step.full:
        tags = {"full", "tenth"} if step.count == SIZE else {"full"}
    elif step.remembered:
        tags = {"refilling" if step.forgotten else "filling"}
        what += f", reading {step.count} of {SIZE}" + " since the jump" * step.forgotten
    else:
        tags = {"unusable"}
        what += ", which is not remembered"
    bounds = [closing for closing in step.closings if closing is not None]
    return Case(
        at=at,
        what=what,
        tags=frozenset(tags),
        allowed={"data": ((min(bounds), max(bounds)),)} if step.full else {},
        said={"data": values[-1]} if values else {},
        count=len(values),
    )
