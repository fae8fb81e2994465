"""The verdicts that several checks of ml_velocity share."""

from __future__ import annotations

import math
from collections.abc import Iterable
from functools import lru_cache

import numpy as np

from grader.checks import model_commands
from grader.checks.commands import Answer, answers, garbage, judged
from grader.checks.model_commands import LEAST_WAY, scan_in_words
from grader.checks.verdict import fail, passes
from grader.exercises.ml_velocity.contract import is_predicted, right_speed
from grader.exercises.ml_velocity.habits import (
    CONTRACT,
    Habit,
    as_said,
    candidates,
    said_for,
    shows,
)
from grader.recording import Recording

SPEED_TOLERANCE = 2e-4  # [m/s]; at this the probes tell distances 2.5 mm apart


def require_speeds(recording: Recording, help: str = "", habit: Habit = CONTRACT) -> None:
    """Fail unless the node commanded the right speed after every scan, and the model said it.

    Or what would be right of a node with another habit.
    """
    found = as_said(recording, judged(recording), habit)
    for answer in found:
        model_commands.require_speed(
            recording,
            answer,
            right_speed(recording, answer.scan, habit.front),
            SPEED_TOLERANCE,
            what=scan_in_words(recording, answer),
            help=_advice(answer, help),
        )
    if is_predicted(recording):
        model_commands.require_said(recording, found, SPEED_TOLERANCE)


def habit_of(recordings: Iterable[Recording]) -> Habit:
    """Return the one wrong habit that explains all commands in SHOWS, or the contract's."""
    return _habit_in(shows(recordings))


@lru_cache(maxsize=2)  # nearly every check asks
def _habit_in(recording: Recording) -> Habit:
    if passes(require_speeds, recording, habit=CONTRACT):
        return CONTRACT
    found = answers(recording)
    wrong = candidates(found, said_for(recording, found))
    return next(
        (habit for habit in wrong if passes(require_speeds, recording, habit=habit)), CONTRACT
    )


def require_going_on(recording: Recording, after: float) -> None:
    """Fail unless the robot drove on after this time [s]."""
    truth = recording.truth
    late = truth.t >= after * 1e9
    moved = np.hypot(np.diff(truth.x[late]), np.diff(truth.y[late])).sum()
    if moved < LEAST_WAY / 2:
        fail(
            "the robot does not drive on when the way is free again",
            expected=f"driving after {after:.0f} s",
            actual=f"{moved:.2f} m driven from then on",
            at=after,
            recording=recording,
            help="Ask the model again at each scan.",
        )


def _advice(answer: Answer, help: str) -> str:
    """Return what to look at after a wrong speed."""
    speed = answer.speed or 0.0
    if math.isnan(speed) and help:  # the model itself may predict NaN, in a field of the right type
        return help
    return garbage(speed) or help
