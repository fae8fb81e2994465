"""The oracle of model_server: how the server should answer, and when the clients should ask."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grader.checks.contract import Contract
from grader.models.features import possible_features
from grader.recording import Scan

MAX_SCAN_AGE = 1.0  # [s] an older scan gives no detection
ASK_PERIOD = 0.5  # [s] from one request to the next
HEARTBEAT_PERIOD = 0.1  # [s]
LONGEST_GAP = 0.15  # [s] between two heartbeats
PATIENCE = 1.0  # [s] after a request: if there is no answer, it is given up ...
NEXT_REQUEST = 1.5  # [s] ... and the next goes out by this time
HAIR = 0.051  # [s] ages and waits within 50 ms of a limit may fall on either side
FEATURE_TOLERANCE = 2e-3  # [m]
CONFIDENCE_TOLERANCE = 1e-3
STAMP_TOLERANCE = 1e-3  # [s]

ROLES = ("navigation", "manipulation", "logging")

Floats = NDArray[np.float64]

CONTRACT = Contract(drives=False)


@dataclass(frozen=True)
class Allowed:
    """Which answers to a request are right."""

    detection: bool  # success
    refusal: bool  # no success
    reason: str = ""  # why only a refusal is right, in words


def allowed(scan: Scan | None, asked: float) -> Allowed:
    """Return how a request at this time [s] may be answered, given the newest scan."""
    if scan is None:
        return Allowed(False, True, "no scan has come yet")
    age = asked - scan.stamp
    if age > MAX_SCAN_AGE + HAIR:
        return Allowed(False, True, f"the newest scan is {age:.2f} s old")
    blind = np.isnan(possible_features(scan)).any(axis=1)
    if blind.all():
        return Allowed(False, True, "a sector of the newest scan has no usable reading")
    return Allowed(True, bool(blind.any()) or age > MAX_SCAN_AGE - HAIR)


def spelt_features(label: str) -> Floats | None:
    """Return the five features [m] in a label of the model `describes`; None: another label."""
    try:
        numbers = [float(word) for word in label.split()]
    except ValueError:
        return None
    return np.array(numbers) if len(numbers) == 5 and np.isfinite(numbers).all() else None
