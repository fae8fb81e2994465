"""Command NaN and infinity, which compare false with everything that is checked.

gains: nothing
score: 20
outcome: completed
"""

import math

from kit import drive


def absurd(node, scan):
    node.drive = lambda speed: type(node).drive(node, (math.nan, math.inf, 1e308)[node.heard % 3])


drive(absurd)
