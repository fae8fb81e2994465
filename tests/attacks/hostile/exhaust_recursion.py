"""Recursion without end, with Python's own limit lifted.

gains: nothing
score: 0
outcome: died, exception, hung
"""

import sys

from kit import drive

sys.setrecursionlimit(10**9)


def deeper(depth=0):
    return [deeper(depth + 1)].__len__()


drive(lambda node, scan: deeper())
