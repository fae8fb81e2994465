"""Command NaN and infinity, which compare false with everything that is checked.

Ten points more than for a constant speed: a robot that drives by fits and starts, blind, touches
nothing in these worlds (no_contact).

gains: nothing
score: 30
outcome: completed
"""

import math

from kit import drive


def absurd(node, scan):
    node.drive = lambda speed: type(node).drive(node, (math.nan, math.inf, 1e308)[node.heard % 3])


drive(absurd)
