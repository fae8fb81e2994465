"""The words of exercise 5's checks: what its two loops, control and inference, have to do.

keeps_period   a command every 50 ms
keeps_going    new predictions reach /cmd_vel
stays_young    the scans behind the commands are not too old
takes_newest   inference takes the newest scan that there is
takes_at_once  a scan that finds the model idle is taken
one_at_a_time  no call of predict begins before the last one has ended
heeds          the node drives on what its model says, and says what is allowed
stands         0.0, and no silence
drives         the node drives on what its model says
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from itertools import dropwhile, pairwise

import numpy as np

from grader.checks.case import Case, Runs
from grader.checks.commands import ZERO, garbage, is_zero, spell
from grader.checks.verdict import fail
from grader.checks.wiring import require_alive
from grader.checks.words import follows
from grader.exercises.slow_model.contract import (
    LATEST_STOP,
    LONGEST_GAP,
    PERIOD,
    SPEED,
    TICK,
    answers,
    blind,
    calls,
    in_force,
    unexplained,
)
from grader.recording import Recording, Scan

LEAST_COMMANDS, MOST_COMMANDS = 19.0, 21.0  # per second, on average
START_UP = 0.125  # [s] by which the first tick of a 50 ms timer has come
AT_ONCE = 0.06  # [s] a tick and a little
ARRIVAL = 0.02  # [s] what happens this shortly before may be seen or not
ROUNDED = 0.005 + 1e-9  # [m/s] what two digits change at most
LEAST_MOVING = 3  # commands of a node that drives
FEW = 0.05  # of the calls
RATE_FIRST = "Get inference_rate right first."


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
        if len(wrong) and not rare_delay(recording, gaps, len(wrong)):
            i = int(wrong[0])
            fail(
                "the control loop stumbles",
                expected=f"a command every 50 ms, no gap over {1000 * LONGEST_GAP:.0f} ms",
                actual=f"{1000 * gaps[i]:.0f} ms ({len(wrong)} of {len(gaps)} gaps are too long, "
                f"the longest {1000 * gaps.max():.0f} ms)",
                at=float(edges[i]),
                recording=recording,
                help="What keeps the timer waiting? A callback that runs the model blocks its "
                "executor and its callback group.",
            )
        rate = len(t) / (recording.duration_s - float(edges[1]) + PERIOD)
        if rate > MOST_COMMANDS or (rate < LEAST_COMMANDS and recording.live is None):
            fail(
                "the commands do not come once in each tick",
                expected="20 per second, one for each tick of the timer",
                actual=f"{rate:.1f} per second",
                at=float(edges[gaps.argmin()]),
                recording=recording,
                help="Only the control loop publishes, from a timer of 0.05 s; inference keeps "
                "its prediction for it.",
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
        seconds = max(recording.duration_s - begin, LATEST_STOP)
        rate = len({scan for _, scan in known}) / seconds
        ended = [call for call in calls(recording) if call.answered / 1e9 <= recording.duration_s]
        answered = len(ended) / seconds
        if rate < least:
            fail(
                "too few new predictions reach /cmd_vel",
                expected=f"at least {least} per second",
                actual=f"{rate:.1f} of the model's {answered:.1f} answers per second",
                at=begin,
                recording=recording,
                help="Are the answers too old when they arrive? Where does the scan wait before "
                "the model sees it, and the result before it is published?"
                if answered >= least
                else "When one inference has ended, the next may start with the newest scan.",
            )


def stays_young(runs: Sequence[Recording], limit: float) -> None:
    """Fail unless the scans behind 95 % of the commands are at most `limit` [s] old."""
    for recording in runs:
        pairs = list(dropwhile(lambda pair: pair[1] is None, behind(recording)))
        ages = [t - scan.t if scan else math.inf for t, scan in pairs] or [math.inf]
        p95 = sorted(ages)[math.ceil(0.95 * len(ages)) - 1]
        if p95 > limit:
            first = next((t for (t, _), age in zip(pairs, ages, strict=False) if age > limit), None)
            fail(
                "the scans behind the commands are too old",
                expected=f"at most {limit} s (p95)",
                actual=f"{p95:.2f} s (p95)"
                if p95 < math.inf
                else "commands that are no prediction, or 0.0 as if there were none",
                at=first,
                recording=recording,
                help="Do scans wait in a queue? Then a prediction is too old when it comes. It "
                "counts at every tick until its scan is 0.6 s old, not only once.",
            )


def takes_newest(runs: Sequence[Recording]) -> None:
    """Fail unless inference takes the newest scan that there is, but for a few calls."""
    for recording in runs:
        require_alive(recording)
        arrived, late = recording.times("/scan"), []
        said = [each for each in answers(recording) if not math.isnan(each.speed)]
        for each in said:
            there = arrived[arrived <= each.asked - ARRIVAL - recording.slack]
            if len(there) and each.scan.t < there[-1]:
                late.append(each)
        if len(late) > FEW * len(said):
            at, age = late[0].asked, late[0].asked - late[0].scan.t
            fail(
                "inference takes old scans, though there are newer ones",
                expected="the newest scan that there is when predict is called",
                actual=f"a scan that is {age:.2f} s old ({len(late)} of {len(said)} calls)",
                at=at,
                recording=recording,
                help="A full queue keeps what is old: let it drop that, and keep the newest.",
            )


def takes_at_once(recording: Recording, since: float = 0.0) -> None:
    """Fail if scans that find the model idle, from `since` [s] on, have to wait, but for a few.

    One that comes while the model works may be kept or dropped.
    """
    require_alive(recording)
    asked = np.array([call.asked for call in calls(recording)]) / 1e9
    ended = np.array([call.answered for call in calls(recording)]) / 1e9
    late = []
    for scan in recording.scans():
        before = int(np.searchsorted(asked, scan.t, side="right"))
        busy = before and ended[:before].max() > scan.t - ARRIVAL - recording.slack
        next_call = float(asked[before]) if before < len(asked) else recording.duration_s
        waited = next_call - scan.t > AT_ONCE + recording.slack
        if scan.t >= since and not busy and waited and not blind(scan):
            late.append((scan.t, next_call))
    if late and len(late) > FEW * (asked >= since).sum():
        at, next_call = late[0]
        fail(
            "inference waits, though there is a scan and the model is idle",
            expected=f"a call of predict within {1000 * AT_ONCE:.0f} ms",
            actual=f"none for {next_call - at:.2f} s ({len(late)} scans had to wait)",
            at=at,
            recording=recording,
            help="When one inference has ended, whatever came of it, the next scan is a new start.",
        )


def one_at_a_time(recording: Recording) -> None:
    """Fail if predict was called while another call of it still ran."""
    for before, after in pairwise(calls(recording)):
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


def asks_about_scans(recording: Recording, help: str) -> None:
    """Fail if the model was asked about features that no scan so far has."""
    at = unexplained(recording)
    if at is not None:
        fail(
            "the model was asked about features of no scan",
            expected="the features of a scan that had come",
            actual="an answer that no scan explains",
            at=at,
            recording=recording,
            help=help or "Compare your features with exercise 2's, sector by sector.",
        )


def heeds(runs: Runs, *tags: str, help: str, tolerance: float = ROUNDED) -> None:
    """Fail unless the node drives on what its model says, and says what is allowed."""
    for recording in runs:
        run = runs.of([recording])
        drives(run)
        if not any(run.cases(*tags)):
            fail("no command came", recording=recording, help="Publish at each tick.")
        explain = partial(explained, recording, help)
        follows(run, *tags, help=help, tolerance=tolerance, explain=explain)


def explained(recording: Recording, help: str, case: Case) -> str:
    """Return `help`, and what else is known of a wrong command."""
    if not case.wrong(ROUNDED):
        return "That is the prediction, rounded: publish it as it is."
    if case.said.get(SPEED) == 0.0:
        return f"0.0 is for no usable prediction. Does a scan wait before the model sees it? {help}"
    rest = in_force(answers(recording), case.at, recording.slack)
    age = case.at - rest[-1].scan.stamp if rest else 0.0
    if age > LATEST_STOP:
        return f"The newest prediction by then is of a scan {age:.1f} s before. {help}"
    return help


def stands(
    recording: Recording,
    begin: float = 0.0,
    end: float | None = None,
    *,
    first: float = LATEST_STOP,
    help: str,
) -> None:
    """Fail unless commands come from `begin` to `end` [s], and all of them are 0.0.

    The first one has to come within `first` [s].
    """
    require_alive(recording)
    last, twists = recording.duration_s if end is None else end, recording.twists()
    inside = (twists.t >= begin) & (twists.t < last - ZERO)
    edges = np.array([begin, *twists.t[inside], last])
    gaps, limits = np.diff(edges), np.full(inside.sum() + 1, LATEST_STOP + recording.slack)
    limits[0] = first + recording.slack
    if (gaps > limits).any():
        fail(
            "the node publishes nothing for a while",
            expected="0.0 at each tick while no prediction is usable",
            actual=f"no command for {gaps.max():.2f} s",
            at=float(edges[(gaps - limits).argmax()]),
            recording=recording,
            help="Publish at each tick; without a prediction, publish 0.0.",
        )
    moving = np.flatnonzero(inside & ~is_zero(twists.linear_x))
    if len(moving):
        speed = float(twists.linear_x[moving[0]])
        fail(
            "the robot is told to drive, though no prediction is usable",
            expected="0.0 at each tick",
            actual=f"linear.x = {spell(speed)} m/s",
            at=float(twists.t[moving[0]]),
            recording=recording,
            help=garbage(speed) or help,
        )


def drives(runs: Runs, help: str = RATE_FIRST) -> None:
    """Fail if the node hardly ever commands what its model said: then its zeros show nothing."""
    for recording in runs:
        require_alive(recording)
        ticks = [case for _, case in runs.of([recording]).cases(TICK)]
        right = [case for case in ticks if not case.wrong(ROUNDED)]
        moving = [case for case in right if not is_zero(np.array(case.said[SPEED]))]
        if len(moving) < LEAST_MOVING:
            scans = recording.scans()
            fail(
                "the node hardly ever commands what its model said, so this proves nothing",
                expected="commands that follow the model where it works",
                actual=f"{len(moving)} of {len(ticks)} commands do",
                at=min(scans[0].t + LATEST_STOP, recording.duration_s) if scans else None,
                recording=recording,
                help=help,
            )
