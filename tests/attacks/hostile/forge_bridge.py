"""Reach into the bridge and put perfect commands beside its own, at times that suit.

gains: nothing
score: 20
outcome: any
"""

import gc
import sys

from kit import attempt, drive

Published = sys.modules["grader.host.frames"].Published


def slip_in(node, scan):
    for thing in gc.get_objects():
        if type(thing).__name__ == "Bridge":
            with attempt():
                old = thing.published[-1] if thing.published else None
                data = old.data if old else bytes(52)
                twist = "geometry_msgs/msg/Twist"
                thing.published.append(Published(10**15, "/cmd_vel", twist, data))


drive(slip_in)
