"""How long the callback of a scan takes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from grader.checks.commands import answered_in_turn
from grader.checks.verdict import fail, inconclusive
from grader.recording import ENDS, Floats, Recording, made_again, rise_of
from grader.recording.views import percentile

OFTEN = 90  # [%] stalls of a machine don't hit one callback in ten, unless threads queue for it
MIN_CALLBACKS = 200  # to measure
HOUR = 3600.0  # [s] a robot drives at least as long


def quick(recordings: Sequence[Recording], limit: float) -> None:
    """Fail unless a scan is dealt with in `limit` [s], at least 99 times in 100."""
    each = [costs(recording) for recording in recordings]
    _, wall, computed, busy = np.concatenate(each, axis=1)
    if len(wall) < MIN_CALLBACKS:
        fail(
            f"only {len(wall)} scans were dealt with before the node ended",
            expected=f"at least {MIN_CALLBACKS} callbacks to measure",
            actual=f"{len(wall)}",
        )
    own, often = percentile(computed, 99), percentile(busy, OFTEN)
    if max(own, often) <= limit:
        if percentile(wall, 99) > limit:
            inconclusive("the machine stalled while the callbacks were being measured")
        return
    longest = int(np.argmax([cost[1].max(initial=0.0) for cost in each]))
    fail(
        "the scan callback takes too long",
        expected=f"at most {1000 * limit:.0f} ms (p99)",
        actual=f"{1000 * own:.0f} ms of computing (p99 of {len(wall)} calls), and with waiting "
        f"at least {1000 * often:.0f} ms in {100 - OFTEN} of 100",
        at=each[longest][0][np.argmax(each[longest][1])],
        recording=recordings[longest],
        help="At 10 Hz the next scan comes after 100 ms. What in the callback costs the time?",
    )


def stays_quick(recordings: Sequence[Recording], limit: float) -> None:
    """Fail if the node makes ends again and again, or would need `limit` [s] within an hour."""
    for recording in recordings:
        for end, many in made_again(recording):
            fail(
                f"the node made {many}",
                expected=f"one of each, in the constructor; more than {ENDS} are too many",
                actual=f"{many} in {recording.duration_s:.0f} s",
                at=recording.duration_s,
                recording=recording,
                help=f"self.create_{end.kind} belongs into the constructor, not into a callback.",
            )
        times, _, computed, _ = costs(recording)
        rise = rise_of(times, computed) if recording.live is None else None
        if rise is None or rise.last + rise.rate * HOUR <= limit:
            continue
        fail(
            "a scan costs more and more time",
            expected=f"at most {1000 * limit:.0f} ms after an hour, too",
            actual=f"{1000 * rise.first:.1f} ms at first, {1000 * rise.last:.1f} ms after "
            f"{recording.duration_s:.0f} s",
            at=times[-1],
            recording=recording,
            help="What do you make or keep for each scan, and never let go? A list that grows, a "
            "timer, a client? Make it once; a deque(maxlen=…) forgets.",
        )


def costs(recording: Recording) -> Floats:
    """Return when each scan came, how long it took, and what of it was computed, and busy [s].

    In real time an answer's delay says it. In virtual time an answer costs what all turns up to the
    next scan cost: a node may put it off to another message's, or ask the judge something on the
    way. Waiting for a CPU is no business. Four rows, a column for each scan.
    """
    cost, scans = recording.compute, recording.times("/scan")
    if count := answered_in_turn(recording):
        scans, answered = scans[:count], recording.twists().t
        begin = np.searchsorted(cost.time, scans)
        end = np.maximum(np.searchsorted(cost.time, answered), begin + 1)
        spans, wall = [slice(*span) for span in zip(begin, end, strict=True)], answered - scans
        cpu = np.array([cost.cpu[span].sum() for span in spans])
        queued = np.array([cost.queued[span].max(initial=0.0) for span in spans])
        return np.stack([scans, wall, np.fmin(wall, cpu), wall - queued])
    begins = sorted({*np.searchsorted(cost.time, scans).tolist()} - {len(cost.time)})
    if not begins:
        return np.zeros((4, 0))
    sums = [np.add.reduceat(each, begins) for each in (cost.computed, cost.busy)]
    return np.stack([cost.time[begins], cost.wall[begins], *sums])
