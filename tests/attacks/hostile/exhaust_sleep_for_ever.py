"""Sleep for ever in native code.

gains: nothing
score: 0
outcome: hung, completed
"""

from kit import drive, libc


def sleep(node, scan):
    while True:
        libc.sleep(1_000)


drive(sleep)
