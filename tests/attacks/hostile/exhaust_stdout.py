"""Flood stdout and stderr, without a line's end and with many.

gains: nothing
score: 20
outcome: completed
"""

import sys

from kit import drive

TEXT = "all checks passed " * 1_000


def flood(node, scan):
    for _ in range(5):
        sys.stdout.write(TEXT)
        sys.stderr.write("\n" * 2_000)


drive(flood)
