"""Which commands belong to which scan."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from grader.recording import Floats, Recording, Scan

LAST_MOMENT = 0.3  # [s] before the end of a run; the answer to a scan then may come after the end
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


def _waited(recording: Recording, begins: Floats, ends: Floats) -> Floats:
    """Return how long in all the node waited for a CPU from each begin to its end [s], (n,)."""
    turns = recording.compute.time
    total = np.concatenate(([0.0], np.cumsum(recording.compute.queued)))
    first = np.maximum(np.searchsorted(turns, begins, side="right") - 1, 0)
    return np.asarray(total[np.maximum(np.searchsorted(turns, ends), first)] - total[first])
