"""Open the gates of all threads at once, so that several run at a time.

gains: nothing
score: 20
outcome: any
"""

import gc

from kit import attempt, drive


def found(name):
    return [thing for thing in gc.get_objects() if type(thing).__name__ == name]


def turn(node, scan):
    for thread in found("VirtualThread"):
        with attempt():
            thread.gate.release()


drive(turn)
