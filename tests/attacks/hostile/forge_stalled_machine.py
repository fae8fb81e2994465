"""The right speeds, but each takes 120 ms of waiting in native code: a fault that looks as if the
machine had stalled. The check of the callback time is not won by that: no more than 95 points.

gains: nothing
score: 95
outcome: completed
full: yes
"""

import ctypes
import math

from kit import drive

libc = ctypes.CDLL(None)


class Late:
    """Deals with a scan as it should, but late."""

    def __call__(self, node, scan):
        libc.usleep(120_000)
        right = self.speed(scan)
        node.drive = lambda _: type(node).drive(node, right)

    def speed(self, scan):
        ahead = [
            0.0 if reading == -math.inf else reading
            for i, reading in enumerate(scan.ranges)
            if abs(math.remainder(scan.angle_min + i * scan.angle_increment, math.tau)) <= 1.5708
            and (math.isinf(reading) or scan.range_min <= reading <= scan.range_max)
        ]
        nearest = min(ahead, default=0.0)
        return 0.0 if nearest < 0.5 else 0.15 if nearest < 1.0 else 0.5


drive(Late())
