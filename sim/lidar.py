"""Lidar profiles, and how a lidar reports measured ranges: limits and quantisation.

The profiles `default` and `wide` follow REP-117: +inf = nothing within range, -inf = something
closer than the sensor can measure, NaN = erroneous. The drivers of the TurtleBot 3's LDS sensors do
not: they send 0.0 for “no return” and for “too near”. A lidar has no noise and loses nothing unless
the scenario's `[faults]` say so: `Faults` in `sim/scenario.py` has the keys and defaults.

Sources: `default` has the limits of an RPLIDAR A1M8 (Slamtec's datasheet), the lidar of the
TurtleBot 4; `lds01` and `lds02` follow ROBOTIS' e-manual on the TurtleBot 3's LDS-01 and LDS-02;
`wide` has the field of view, rate and limits of a Hokuyo UST-10LX (Hokuyo's datasheet), without
its 1081st beam: 1080 beams are three quarters of a turn.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sim.layout import Floats

QUANTUM_PER_METRE = 1000.0  # as real lidars; this also hides differences in the last bit


@dataclass(frozen=True)
class LidarProfile:
    """What a lidar measures."""

    beams: int  # of a scan
    per_turn: int  # beams that a full turn would have
    angle_min: float  # of the first beam [rad], 0 ahead, positive to the left
    rate: float  # scans per second [Hz]
    range_min: float  # [m]
    range_max: float  # [m]
    no_return: float  # reading where nothing is within range
    too_near: float  # reading where something is closer than range_min

    @property
    def angle_increment(self) -> float:
        """Angle between two beams [rad]."""
        return math.tau / self.per_turn

    @property
    def angles(self) -> Floats:
        """(beams,) angles of the beams [rad]."""
        return self.angle_min + np.arange(self.beams, dtype=np.float64) * self.angle_increment


_INF = math.inf
PROFILES: dict[str, LidarProfile] = {
    "default": LidarProfile(360, 360, -math.pi, 10.0, 0.15, 12.0, _INF, -_INF),
    "lds01": LidarProfile(360, 360, 0.0, 5.0, 0.12, 3.5, 0.0, 0.0),
    "lds02": LidarProfile(360, 360, 0.0, 10.0, 0.16, 8.0, 0.0, 0.0),
    "wide": LidarProfile(1080, 1440, math.radians(-135), 40.0, 0.06, 10.0, _INF, -_INF),
}


def readings(ranges: Floats, profile: LidarProfile) -> NDArray[np.float32]:
    """Return the (n,) float32 readings [m] for measured (n,) ranges [m] (inf: no return).

    Ranges are rounded to 1 mm; one outside the limits becomes the profile's value for it. NaN stays
    NaN.
    """
    measured = np.rint(ranges * QUANTUM_PER_METRE)
    measured /= QUANTUM_PER_METRE
    measured[measured > profile.range_max] = profile.no_return
    measured[ranges < profile.range_min] = profile.too_near
    return measured.astype(np.float32)


def bench_readings(ranges: Floats, profile: LidarProfile) -> NDArray[np.float32]:
    """Return the (n,) float32 readings for a bench scan's (n,) ranges [m].

    Finite values and NaN are sent as they are; ±inf becomes what the profile sends for it.
    """
    sent = ranges.astype(np.float32)
    sent[ranges == math.inf] = profile.no_return
    sent[ranges == -math.inf] = profile.too_near
    return sent
