"""The expert whose speeds exercise 2's models learn; only an instructor's copy has this file.

The expert looks at the whole exact scan. No rule of three features and no polynomial of all five up
to the third degree comes as near as exercise 2 asks (`tests/grader/models/test_expert.py`). Whoever
knows this file comes near with its own formula, for the published expert alone.
"""

from dataclasses import astuple, dataclass

import numpy as np
from numpy.typing import NDArray

from grader.models.features import FRONT_EDGE
from grader.models.scans import PROFILE

Floats = NDArray[np.float64]

MAX_SPEED = 0.5  # [m/s]
BRAKING = 0.9  # [m/s²]
FAR = 4.0  # [m] what is farther ahead is not looked at
NEAREST = 5  # readings of a side make its room
SPREAD = 0.05  # by this part a character's numbers vary
DEGREES = np.degrees(PROFILE.angles)


@dataclass(frozen=True)
class Character:
    """An expert's habits: the distances and speeds it keeps."""

    short: float  # [m] stops this far from what is ahead
    reaction: float  # [s] before it brakes
    narrow: float  # [m] to the nearer side, where it drives slowest
    wide: float  # [m] more than that, and the side no longer matters
    squeezed: float  # part of the speed that is left there
    closed: float  # [m] of room ahead, where it drives slowest
    open: float  # [m] more than that, and the room ahead no longer matters
    boxed: float  # part of the speed that is left there


PUBLISHED = Character(0.3, 0.35, 0.2, 0.8, 0.25, 0.6, 2.0, 0.4)
OTHERS = (
    Character(0.27, 0.25, 0.14, 0.5, 0.05, 0.4, 1.4, 0.1),
    Character(0.28, 0.26, 0.17, 1.42, 0.07, 1.04, 1.21, 0.07),
    Character(0.34, 0.27, 0.43, 0.89, 0.09, 1.14, 1.75, 0.12),
)


def character(seed: int | None) -> Character:
    """Return the expert of a graded class or student; None is the published one."""
    if seed is None:
        return PUBLISHED
    rng = np.random.default_rng((seed, 2))
    chosen = np.array(astuple(OTHERS[rng.integers(len(OTHERS))]))
    return Character(*(chosen * rng.uniform(1 - SPREAD, 1 + SPREAD, len(chosen))).tolist())


def speeds(exact: Floats, expert: Character) -> Floats:
    """Return the expert's (n,) speeds [m/s] for (n, 360) exact ranges [m]."""
    ahead = exact[:, np.abs(DEGREES) <= FRONT_EDGE]
    sides = [exact[:, DEGREES > FRONT_EDGE], exact[:, DEGREES < -FRONT_EDGE]]
    side = np.min([np.sort(s, axis=1)[:, :NEAREST].mean(axis=1) for s in sides], axis=0)
    room = np.minimum(ahead, FAR).mean(axis=1)
    gap = np.maximum(ahead.min(axis=1) - expert.short, 0.0)
    lost = BRAKING * expert.reaction
    stopping: Floats = np.minimum(MAX_SPEED, np.sqrt(lost**2 + 2 * BRAKING * gap) - lost)
    squeezed = expert.squeezed + (1 - expert.squeezed) * _step(side, expert.narrow, expert.wide)
    boxed = expert.boxed + (1 - expert.boxed) * _step(room, expert.closed, expert.open)
    return stopping * squeezed * boxed


def _step(value: Floats, begin: float, width: float) -> Floats:
    """Return 0 at `begin`, 1 at `begin + width`, and a smooth step between."""
    part = np.clip((value - begin) / width, 0.0, 1.0)
    smooth: Floats = part**2 * (3 - 2 * part)
    return smooth
