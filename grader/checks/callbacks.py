"""How long the callback of a scan takes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from grader.checks.turns import answered_in_turn, until_next_scan
from grader.checks.verdict import fail, inconclusive
from grader.recording import Recording

OFTEN = 90  # [%] stalls of a machine don't hit one callback in ten, unless threads queue for it
LEAST = 200  # callbacks, to measure


def quick(recordings: Sequence[Recording], limit: float) -> None:
    """Fail unless a scan is dealt with in `limit` [s], at least 99 times in 100."""
    costs = [_costs(recording) for recording in recordings]
    wall, cpu, queued = (np.concatenate(part) for part in zip(*costs, strict=True))
    if len(wall) < LEAST:
        fail(
            f"only {len(wall)} scans were dealt with before the node ended",
            expected=f"at least {LEAST} callbacks to measure",
            actual=f"{len(wall)}",
        )
    p99 = float(np.percentile(wall, 99))
    computed, busy = np.concatenate([until_next_scan(r) for r in recordings], axis=1)
    own = _most(99, np.fmin(wall, cpu), computed)  # [s] spent computing
    often = _most(OFTEN, wall - queued, busy)  # [s] without the wait for a CPU
    if max(p99, own, often) <= limit:
        return
    if max(own, often) <= limit:
        inconclusive("the machine stalled while the callbacks were being measured")
    longest = int(np.argmax([max(run_wall, default=0.0) for run_wall, _, _ in costs]))
    fail(
        "the scan callback takes too long",
        expected=f"at most {1000 * limit:.0f} ms (p99)",
        actual=f"{1000 * own:.0f} ms (p99 of {len(wall)} calls)"
        if own > limit
        else f"at least {1000 * often:.0f} ms in {100 - OFTEN} of 100 calls, mostly spent waiting",
        at=_times(recordings[longest])[np.argmax(costs[longest][0])],
        recording=recordings[longest],
        help="At 10 Hz the next scan comes after 100 ms. What in the callback costs the time?",
    )


def _most(percent: float, *durations: np.ndarray) -> float:
    """Return the largest of the percentiles [s] of several measures."""
    return max(float(np.percentile(each, percent)) for each in durations if len(each))


def _costs(recording: Recording) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return wall time, CPU time and the wait for a CPU [s] of each callback of a scan."""
    compute = recording.compute
    scans = recording.times("/scan")
    count = answered_in_turn(recording)
    if not count:
        with_scan = np.isin(compute.time, scans)
        return compute.wall[with_scan], compute.cpu[with_scan], compute.queued[with_scan]
    scans, answered = scans[:count], recording.twists().t
    begin = np.searchsorted(compute.time, scans)
    end = np.maximum(np.searchsorted(compute.time, answered), begin + 1)
    spans = [slice(*span) for span in zip(begin, end, strict=True)]
    cpu = np.array([compute.cpu[span].sum() for span in spans])
    queued = np.array([compute.queued[span].max(initial=0.0) for span in spans])
    return answered - scans, cpu, queued


def _times(recording: Recording) -> np.ndarray:
    """Return when the callbacks in `_costs` began [s]."""
    scans = recording.times("/scan")
    if count := answered_in_turn(recording):
        return scans[:count]
    times: np.ndarray = recording.compute.time
    return times[np.isin(times, scans)]
