"""How far a robot drove, and whether it touched anything."""

from __future__ import annotations

import numpy as np

from grader.checks.moments import first_contact
from grader.checks.verdict import fail
from grader.recording import Recording


def path_length(recording: Recording) -> float:
    """Return how far the robot drove [m]."""
    truth = recording.truth
    return float(np.hypot(np.diff(truth.x), np.diff(truth.y)).sum())


def require_no_contact(
    recording: Recording,
    help: str,
    *,
    message: str = "the robot ran into something",
    expected: str = "no contact",
) -> None:
    """Fail if the robot touched anything."""
    if recording.truth.contact.any():
        fail(
            message,
            expected=expected,
            actual="contact",
            at=first_contact(recording),
            recording=recording,
            help=help,
        )
