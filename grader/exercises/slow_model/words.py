"""The words of exercise 5's checks: what its two loops, control and inference, have to do.

keeps_period   a command every 50 ms
keeps_going    new predictions reach /cmd_vel
stays_young    the scans behind the commands are not too old
heeds          the node says, and asks, what is allowed
stands         0.0, and no silence
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from itertools import dropwhile, pairwise

import numpy as np

from grader.checks.case import Runs
from grader.checks.commands import ZERO
from grader.checks.verdict import fail
from grader.checks.wiring import require_alive
from grader.checks.words import every, follows
from grader.exercises.slow_model.contract import LATEST_STOP, PERIOD, TICK, answers, in_force
from grader.recording import Recording
from sim.messages import CMD_VEL_TOPIC

LONGEST_GAP = 0.075  # [s] between two commands
LEAST_RATE = 3.0  # [Hz] of new predictions
AGE_P95 = 0.58  # [s] of the scan behind a command
LEAST_COMMANDS, MOST_COMMANDS = 19.0, 21.0  # per second, on average
START_UP = 0.125  # [s] by which the first tick of a 50 ms timer has come
ROUNDED = 0.005 + 1e-9  # [m/s] what two digits change at most

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


def behind(recording: Recording) -> list[tuple[float, float]]:
    """Return when each command came, and the scan behind it [s]: -inf if it is no prediction."""
    require_alive(recording)
    said, twists, found = answers(recording), recording.twists(), []
    for t, speed in zip(twists.t.tolist(), twists.linear_x.tolist(), strict=True):
        rest = in_force(said, t, recording.slack)
        scans = [each.scan.t for each in rest if abs(each.speed - speed) <= ROUNDED]
        found.append((t, scans[-1] if scans else -math.inf))
    return found


def keeps_going(runs: Sequence[Recording], least: float) -> None:
    """Fail unless new predictions reach /cmd_vel at this rate [Hz]."""
    for recording in runs:
        known = [(t, scan) for t, scan in behind(recording) if scan > -math.inf]
        begin = known[0][0] if known else min(LATEST_STOP, recording.duration_s)
        rate = len({scan for _, scan in known}) / max(recording.duration_s - begin, LATEST_STOP)
        if rate < least:
            fail(
                "too few new predictions reach /cmd_vel",
                expected=f"at least {least} per second",
                actual=f"{rate:.1f} per second",
                at=begin,
                recording=recording,
                help="When one inference has ended, the next may start with the newest scan. "
                "Where does a scan wait before the model sees it, and a result before control "
                "does?",
            )


def stays_young(runs: Sequence[Recording], limit: float) -> None:
    """Fail unless the scans behind 95 % of the commands are at most `limit` [s] old."""
    for recording in runs:
        pairs = list(dropwhile(lambda pair: pair[1] == -math.inf, behind(recording)))
        ages = [t - scan for t, scan in pairs] or [math.inf]
        p95 = sorted(ages)[math.ceil(0.95 * len(ages)) - 1]
        if p95 > limit:
            fail(
                "the scans behind the commands are too old",
                expected=f"at most {limit} s (p95)",
                actual=f"{p95:.2f} s (p95)" if p95 < math.inf else "commands without a prediction",
                at=next((t for t, scan in pairs if t - scan > limit), None),
                recording=recording,
                help="Do scans wait in a queue? Then a prediction is too old when it comes. It "
                "counts at every tick until its scan is 0.6 s old, not only once.",
            )


def stands(
    runs: Runs, tag: str = TICK, begin: float = 0.0, end: float | None = None, *, help: str
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
