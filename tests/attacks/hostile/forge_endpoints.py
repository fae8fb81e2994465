"""Claim endpoints that do not exist, in the names of the grader's own nodes.

gains: nothing
score: 20
outcome: any
"""

import gc
import sys

from kit import attempt, drive

EndpointReport = sys.modules["grader.host.frames"].EndpointReport


def claim(node, scan):
    for thing in gc.get_objects():
        if type(thing).__name__ == "Bridge":
            with attempt():
                thing._endpoints.append(
                    EndpointReport("publisher", "/course_judge", "/ground_truth/odom", "a/b/C")
                )


drive(claim)
