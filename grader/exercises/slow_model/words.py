"""The words of exercise 5's checks: what its two loops, control and inference, have to do.

keeps_period   a command every 50 ms
keeps_going    new predictions reach /cmd_vel
stays_young    the scans behind the commands are not too old
asks           predict is asked what it has to be
heeds          the node says what is allowed, by what its model says
stands         0.0, and no silence
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from itertools import dropwhile, pairwise

import numpy as np

from grader.checks.case import Case, Runs
from grader.checks.commands import ZERO
from grader.checks.verdict import fail
from grader.checks.wiring import require_alive
from grader.checks.words import every, follows
from grader.exercises.slow_model.contract import (
    LATEST_STOP,
    LONGEST_GAP,
    PERIOD,
    TICK,
    answers,
    in_force,
    questions,
)
from grader.recording import Recording, Scan
from sim.messages import CMD_VEL_TOPIC

LEAST_COMMANDS, MOST_COMMANDS = 19.0, 21.0  # per second, on average
START_UP = 0.125  # [s] by which the first tick of a 50 ms timer has come
ROUNDED = 0.005 + 1e-9  # [m/s] what two digits change at most


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
                "waiting? A callback that runs the model blocks its executor and its group.",
            )


def rare_delay(recording: Recording, gaps: np.ndarray, wrong: int) -> bool:
    """Return whether, in real time, the gaps may be the scheduler's: few are wrong, by little."""
    few = wrong <= max(1, len(gaps) // 100)
    return recording.live is not None and few and gaps.max() <= 2 * LONGEST_GAP


def behind(recording: Recording) -> list[tuple[float, Scan | None]]:
    """Return when each command came [s], and the scan behind it: None if it is no answer."""
    require_alive(recording)
    said, twists, found = answers(recording), recording.twists(), []
    for t, speed in zip(twists.t.tolist(), twists.linear_x.tolist(), strict=True):
        rest = reversed(in_force(said, t, recording.slack))
        scan = next((each.scan for each in rest if abs(each.speed - speed) <= ROUNDED), None)
        found.append((t, scan))
    return found


def keeps_going(runs: Sequence[Recording], least: float) -> None:
    """Fail unless new predictions reach /cmd_vel at this rate [Hz]."""
    for recording in runs:
        known = [(t, scan.t) for t, scan in behind(recording) if scan]
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
        pairs = list(dropwhile(lambda pair: pair[1] is None, behind(recording)))
        ages = [t - scan.t if scan else math.inf for t, scan in pairs] or [math.inf]
        p95 = sorted(ages)[math.ceil(0.95 * len(ages)) - 1]
        if p95 > limit:
            fail(
                "the scans behind the commands are too old",
                expected=f"at most {limit} s (p95)",
                actual=f"{p95:.2f} s (p95)" if p95 < math.inf else "commands without a prediction",
                at=next((t for (t, _), age in zip(pairs, ages, strict=False) if age > limit), None),
                recording=recording,
                help="Do scans wait in a queue? Then a prediction is too old when it comes. It "
                "counts at every tick until its scan is 0.6 s old, not only once.",
            )


def asks(runs: Runs, *tags: str, help: str) -> None:
    """Fail unless predict is asked what it has to be, on each occasion with one of these tags."""
    for recording in runs:
        follows(
            Runs([recording], lambda run: tuple(questions(run))), *tags, help=help, topic="predict"
        )


def heeds(runs: Runs, *tags: str, help: str, tolerance: float = ROUNDED) -> None:
    """Fail unless the node says what is allowed, on each occasion with one of these tags."""
    for recording in runs:
        explain = partial(_explain, recording)
        follows(runs.of([recording]), *tags, help=help, tolerance=tolerance, explain=explain)


def _explain(recording: Recording, case: Case) -> str:
    if not case.wrong(ROUNDED):
        return "That is the prediction, rounded: publish it as it is."
    rest = in_force(answers(recording), case.at, recording.slack)
    age = case.at - rest[-1].scan.stamp if rest else 0.0
    return f"The newest prediction is of a scan {age:.1f} s before." * (age > LATEST_STOP)


def stands(
    runs: Runs, tag: str = TICK, begin: float = 0.0, end: float | None = None, *, help: str
) -> None:
    """Fail unless commands come from `begin` to `end` [s], and those with the tag are allowed.

    Where no prediction is usable, only 0.0 is.
    """
    for recording in runs:
        last = recording.duration_s if end is None else end
        every(
            recording, CMD_VEL_TOPIC, PERIOD, START_UP - PERIOD, begin=begin, end=last,
            help="Publish at each tick; without a prediction, publish 0.0.",
        )  # fmt: skip
        heeds(runs.of([recording]), tag, help=help)
