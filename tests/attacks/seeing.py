"""The right speeds, for those honest submissions whose oddity lies elsewhere."""

import math


def right_speed(scan) -> float:
    """Return the speed [m/s] for a scan."""
    seen = []
    for index, reading in enumerate(scan.ranges):
        angle = math.remainder(scan.angle_min + index * scan.angle_increment, math.tau)
        if abs(angle) > math.pi / 2:
            continue
        if reading == -math.inf:
            seen.append(0.0)
        elif reading == math.inf or scan.range_min <= reading <= scan.range_max:
            seen.append(reading)
    nearest = min(seen, default=0.0)
    return 0.0 if nearest < 0.5 else 0.15 if nearest < 1.0 else 0.5
