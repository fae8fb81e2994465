"""The words of exercise 5's checks: what its two loops, control and inference, have to do."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from itertools import pairwise

import numpy as np

from grader.checks.case import Runs
from grader.checks.commands import ZERO
from grader.checks.verbs import every, follows
from grader.checks.verdict import fail
from grader.checks.wiring import require_alive
from grader.exercises.slow_model.contract import PERIOD, ROUNDED
from grader.recording import Recording
from sim.messages import CMD_VEL_TOPIC

LONGEST_GAP = 0.075  # [s] between two commands
LEAST_COMMANDS, MOST_COMMANDS = 19.0, 21.0  # per second, on average
START_UP = 0.125  # [s] by which the first tick of a 50 ms timer has come

heeds = partial(follows, tolerance=ROUNDED)


def keeps_period(runs: Sequence[Recording]) -> None:
    """Fail unless commands come every 50 ms, from the first one to the end."""
    for recording in runs:
        require_alive(recording)
        t = recording.twists().t
        edges = np.array([0.0, *t, recording.duration_s])
        gaps = np.diff(edges)
        limits = LONGEST_GAP + np.array([recording.waited(*pair) for pair in pairwise(edges)])
        limits[0] = math.inf if len(t) else START_UP
        wrong = np.flatnonzero(gaps > limits + ZERO)
        stumbles = len(wrong) and not rare_delay(recording, gaps, len(wrong))
        rate = len(t) / (recording.duration_s - float(edges[1]) + PERIOD)
        slow = rate < LEAST_COMMANDS and recording.live is None
        if stumbles or slow or rate > MOST_COMMANDS:
            fail(
                "the control loop stumbles",
                expected=f"a command every 50 ms, no gap over {1000 * LONGEST_GAP:.0f} ms",
                actual=f"{rate:.1f} per second; {len(wrong)} of {len(gaps)} gaps are too long, "
                f"the longest {1000 * gaps.max():.0f} ms",
                at=float(edges[wrong[0] if len(wrong) else gaps.argmin()]),
                recording=recording,
                help="Only the control loop publishes, from a timer of 0.05 s. What keeps it "
                "waiting? The one thread that runs the model, too? Then give each a callback group "
                "and a MultiThreadedExecutor to both, or a worker to the model. A lock, a queue?",
            )


def rare_delay(recording: Recording, gaps: np.ndarray, wrong: int) -> bool:
    """Return whether, in real time, the gaps may be the scheduler's: few are wrong, by little."""
    few = wrong <= max(1, len(gaps) // 100)
    return recording.live is not None and few and gaps.max() <= 2 * LONGEST_GAP


def stands(
    runs: Runs, tag: str = "tick", begin: float = 0.0, end: float | None = None, *, help: str
) -> None:
    """Fail unless commands come from `begin` to `end` [s], and those with the tag are allowed.

    Where no prediction is usable, only 0.0 is.
    """
    for recording in runs:
        every(
            recording, CMD_VEL_TOPIC, PERIOD, START_UP - PERIOD, begin=begin, end=end,
            help="Publish at each tick; without a prediction, publish 0.0.",
        )  # fmt: skip
        heeds(runs.of([recording]), tag, help=help)
