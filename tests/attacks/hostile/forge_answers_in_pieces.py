"""The right speeds after 150 ms, in pieces of 50 ms: between them the judge is asked something.

gains: nothing
score: 95
outcome: completed
full: yes
"""

import math

from kit import drive, libc

from grader.host.frames import Question
from grader.host.supplied.kept import desk


class InPieces:
    """Deals with a scan as it should, in three exchanges with the judge."""

    def __call__(self, node, scan):
        for _ in range(3):
            libc.usleep(50_000)
            desk.ask(Question(0, "load", "no.pkl"))
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


drive(InPieces())
