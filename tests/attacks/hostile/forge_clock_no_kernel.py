"""Take the kernel away in the middle of a callback.

gains: nothing
score: 20
outcome: any
"""

import gc

from kit import attempt, drive


def found(name):
    return [thing for thing in gc.get_objects() if type(thing).__name__ == name]


def turn(node, scan):
    for session in found("Session"):
        with attempt():
            session.kernel = session.bridge = session.clocks = None


drive(turn)
