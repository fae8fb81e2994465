"""Which commands belong to which scan."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from grader.recording import Floats, Recording, Scan

LAST_MOMENT = 0.3  # [s] before the end of a run; the answer to a scan then may come after the end
UNEXPLAINED = 0.02  # [s] of a turn without CPU time; below it nobody measured the wait for a CPU
LATEST = 0.5  # [s] from a scan to its answer, in real time, without the node's wait for a CPU


def turns(recording: Recording) -> tuple[tuple[Scan, ...], NDArray[np.intp]]:
    """Return the n scans that count, and where in `twists()` the answers to each begin, (n + 1,).

    The answers to a scan are the commands between it and the next scan; in real time, if each scan
    was answered by one command, that command, even if it came late. The last entry is where the
    answers to the last scan end.
    """
    scans, commands = recording.scans(), recording.twists().t
    if count := answered_in_turn(recording):
        return scans[:count], np.arange(count + 1)
    bounds = [*(scan.t for scan in scans), math.inf]
    return scans, np.searchsorted(commands, bounds, side="left")


def answered_in_turn(recording: Recording) -> int:
    """Return how many scans were answered by one command each, in real time, even if late.

    A callback that takes longer than a period answers after the next scan has come; the answers to
    the last scans may come after the end. 0 if commands don't follow scans like this, and in
    virtual time, where computing takes no time and nothing is late.
    """
    scans, commands = recording.times("/scan"), recording.twists().t
    count = len(commands)
    if recording.live is None or count > len(scans):
        return 0
    delays = commands - scans[:count]
    unanswered = scans[count:] <= recording.duration_s - LAST_MOMENT
    latest = LATEST + _waited(recording, scans[:count], commands)
    if np.any(delays < 0.0) or np.any(delays > latest) or np.any(unanswered):
        return 0
    return count


def until_next_scan(recording: Recording) -> Floats:
    """Return what the node computed, and was busy, from each scan to the next [s], (2, n).

    In virtual time the answer to a scan costs what all turns up to the next scan cost: a node may
    put it off to another message's, or ask the judge something on the way. Waiting for a CPU is no
    business. In real time the answer's delay says it, and n is 0.
    """
    cost = recording.compute
    begins = np.unique(np.searchsorted(cost.time, recording.times("/scan")))
    begins = begins[begins < len(cost.time)]
    if recording.live is not None or not len(begins):
        return np.zeros((2, 0))
    computed = np.fmin(cost.wall, cost.cpu)
    waited = cost.wall - computed > UNEXPLAINED
    busy = np.where(waited, np.maximum(cost.wall - cost.queued, computed), computed)
    return np.stack([np.add.reduceat(each, begins) for each in (computed, busy)])


def _waited(recording: Recording, begins: Floats, ends: Floats) -> Floats:
    """Return how long in all the node waited for a CPU from each begin to its end [s], (n,)."""
    turns = recording.compute.time
    total = np.concatenate(([0.0], np.cumsum(recording.compute.queued)))
    first = np.maximum(np.searchsorted(turns, begins, side="right") - 1, 0)
    return np.asarray(total[np.maximum(np.searchsorted(turns, ends), first)] - total[first])
