"""When to open the replay of a failure that is about a whole run.

A node that publishes nothing, or a robot that never moves, has no moment of its own; so these
failures name the most telling one.
"""

from __future__ import annotations

import numpy as np

from grader.recording import Recording

STILL = 1e-4  # [m] between two samples of the truth, 20 ms apart: 5 mm/s


def first_asked(recording: Recording) -> float | None:
    """Return when the node was sent its first message [s]; None: never."""
    return recording.delivered[0].time / 1e9 if recording.delivered else None


def first_contact(recording: Recording) -> float | None:
    """Return when the robot first touched something [s]; None: never."""
    truth = recording.truth
    if not truth.contact.any():
        return None
    return float(truth.t[int(np.argmax(truth.contact))]) / 1e9


def came_to_rest(recording: Recording) -> float | None:
    """Return when the robot stopped for good [s]; if it never moved, when it was asked to.

    A robot that still creeps at the end comes to rest there.
    """
    truth = recording.truth
    moving = np.flatnonzero(np.hypot(np.diff(truth.x), np.diff(truth.y)) > STILL)
    if not len(moving):
        return first_asked(recording)
    return float(truth.t[int(moving[-1]) + 1]) / 1e9
