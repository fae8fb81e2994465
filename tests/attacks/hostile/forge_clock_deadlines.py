"""Empty every queue in which the kernel keeps what is to happen when.

gains: nothing
score: 20
outcome: any
"""

import gc

from kit import attempt, drive


def found(name):
    return [thing for thing in gc.get_objects() if type(thing).__name__ == name]


def turn(node, scan):
    for kernel in found("Kernel"):
        for value in vars(kernel).values():
            if isinstance(value, list):
                with attempt():
                    value.clear()


drive(turn)
