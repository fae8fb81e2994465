"""What an agent of trend_memory is, and on which occasions it says what."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from grader.checks.case import Case, answered, exactly
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
    """Return the occasions of each scan: its command, how many closing speeds come, and which.

    The others are missing where the contract leaves open whether a closing speed comes.
    """
    found, said = answers(recording), published(recording, TOPIC, FLOAT64)
    begins = [*(answer.scan.t for answer in found), math.inf]
    bounds = np.searchsorted([time for time, _ in said], begins)
    occasions = []
    for i, step in enumerate(steps([answer.scan for answer in found])):
        occasions.append(_command(found[i], step))
        if step.due is not None:
            values = [float(value.data) for _, value in said[bounds[i] : bounds[i + 1]]]
            what = f"scan {i + 1} ({found[i].what})"
            occasions += _closing_speeds(found[i].scan.t, what, step, values)
    return occasions


def _command(answer: Answer, step: Step) -> Case:
    what, closing = answer.what, step.closings[0]
    if closing and closing > 0.0:
        what += f", which comes closer at {closing:.2f} m/s"
    tags = ("command", "forgotten") if step.forgotten else ("command",)
    return answered(answer, {"linear.x": exactly(*step.speeds)}, *tags, what=what)


def _closing_speeds(at: float, what: str, step: Step, values: Sequence[float]) -> Iterator[Case]:
    """Yield how many come, one or none (`pace`), and what the one is."""
    if not step.remembered:
        what += ", which is not remembered"
    elif not step.due:
        what += f", reading {step.count} of {SIZE}"
    due = "due" if step.due else "filling" if step.remembered else "not_due"
    right, count = {"count": frozenset({"1" if step.due else "0"})}, {"count": str(len(values))}
    yield Case(at, what, frozenset({"pace", due}), right, count)
    if step.due:
        numbers = [closing for closing in step.closings if closing is not None]
        tags = frozenset({"full", "tenth"} if step.count == SIZE else {"full"})
        speed = {"data": ((min(numbers), max(numbers)),)}
        yield Case(at, what, tags, speed, {"data": values[-1]} if values else {})
