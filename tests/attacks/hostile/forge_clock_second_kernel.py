"""Put a kernel of its own, with a clock of its own, in the place of the first.

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
            other = type(session.kernel)()
            other.now, other.world = 10**12, session
            session.kernel = other


drive(turn)
