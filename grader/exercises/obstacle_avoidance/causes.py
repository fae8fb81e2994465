"""Which beams a node reacts to, from its answers to bench scans: for exercise 1.

A node that perceives rightly may still decide wrongly; but its speed never falls as the distance
that it sees grows. So the right sector, and each wrong one, is tried: does the speed follow the
smallest distance in it, in every scan? If several do, or the right one does, nothing is said.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grader.checks.commands import Answer, answers
from grader.checks.evidence import Evidence, Trials
from grader.recording import Floats

BENCH = "avoid_zones"
SAME = 1e-3  # [m/s], [m]
LEAST = 12  # scans with an answer
EDGE = 0.25  # [°] a beam's angle is a float32
HINT = "2.1"
# checks whose scans a wrong sector reads wrongly
SEEN = (
    "clear_zone", "slow_zone", "stop_zone", "ignores_behind", "sees_sides", "infinite_readings",
    "invalid_readings", "minus_infinity", "blind", "no_contact", "drives_on",
)  # fmt: skip

Sector = Callable[[Floats], NDArray[np.bool_]]  # of the beams' angles [°], -180 … 180


class Mistake(NamedTuple):
    """A wrong sector."""

    text: str  # what the speed follows
    sees: tuple[Sector, ...]  # with and without the beam on an edge


def _cone(half: float) -> Sector:
    return lambda degrees: np.abs(degrees) <= half


def _right(degrees: Floats) -> NDArray[np.bool_]:
    return np.abs(degrees) <= 90


MISTAKES = (
    Mistake(
        "thing behind the robot, and not ahead. This lidar's first beam looks backwards "
        "(angle_min = -π): is it taken for straight ahead?",
        (lambda degrees: np.abs(degrees) >= 90,),
    ),
    Mistake(
        "thing anywhere around the robot, also behind it; only ±90° of ahead count. Is every "
        "beam's angle compared, and in radians (π/2, not 90)?",
        (np.isfinite,),
    ),
    Mistake(
        "thing on the robot's left, ahead and behind: ahead is -90° … 90°, not 0° … 180°.",
        (lambda degrees: degrees >= -EDGE, lambda degrees: degrees >= EDGE),
    ),
    Mistake(
        "thing on the robot's right, ahead and behind: ahead is -90° … 90°.",
        (lambda degrees: degrees <= EDGE, lambda degrees: degrees <= -EDGE),
    ),
    Mistake(
        "thing in the left half of what is ahead, and not in the right.",
        (
            lambda degrees: (degrees >= -EDGE) & (degrees <= 90),
            lambda degrees: (degrees >= EDGE) & (degrees <= 90),
        ),
    ),
    Mistake(
        "thing in the right half of what is ahead, and not in the left.",
        (
            lambda degrees: (degrees <= EDGE) & (degrees >= -90),
            lambda degrees: (degrees <= -EDGE) & (degrees >= -90),
        ),
    ),
    Mistake(
        "thing in the first beam, which points backwards (angle_min = -π). Look at every beam "
        "within ±90° of ahead.",
        (lambda degrees: np.abs(degrees) >= 180 - 2 * EDGE,),
    ),
    Mistake(
        "thing ahead or anywhere on the right, also behind: is only angle > π/2 left out, and not "
        "angle < -π/2?",
        (lambda degrees: degrees <= 90,),
    ),
    Mistake(
        "thing ahead or anywhere on the left, also behind: is only angle < -π/2 left out, and not "
        "angle > π/2?",
        (lambda degrees: degrees >= -90,),
    ),
)
STOP, SLOW = 0.5, 1.0  # [m] the limits of the zones
STOPS = ("stop_zone", "sees_sides", "minus_infinity", "invalid_readings", "no_contact")
NEVER_STOPS = (
    "nearer than 0.5 m the node drives on at {speed:.2f} m/s, as from 0.5 to 1.0 m. Is `distance < "
    "1.0` asked first? It is true of 0.3, too: ask `distance < 0.5` before."
)
CONES = (2, 10, 15, 20, 22.5, 25, 30, 35, 40, 45, 50, 55, 60, 65, 70, 75, 80)  # [°] half of it
NARROW = (
    "thing straight ahead, in hardly more than one beam. Does it look at one beam only, or compare "
    "degrees with radians? Everything within ±90° (π/2) counts."
)


def seen(trials: Trials, failed: Sequence[str]) -> Evidence | None:
    """Return which wrong sector explains all the node's answers, if the right one doesn't."""
    bench = trials.get(BENCH)
    if bench is None or not bench.outcome.completed:
        return None
    answered = [answer for answer in answers(bench) if answer.speed is not None]
    if len(answered) < LEAST:
        return None
    if follows(answered, _right):
        return _never_stops(failed, answered)
    texts = [text for text, sees in MISTAKES if any(follows(answered, each) for each in sees)]
    if len(texts) > 1:
        return None
    cones = [half for half in CONES if follows(answered, _cone(half))]
    if cones and not texts:
        narrow = f"thing within about ±{cones[-1]:.0f}° of ahead; everything within ±90° counts."
        texts = [NARROW if CONES[0] in cones else narrow]
    elif cones:
        return None
    if not texts:
        return None
    explained = [check for check in failed if check in SEEN]
    text = f"in all {len(answered)} scans of {BENCH} the speed follows the nearest {texts[0]}"
    return Evidence(text, hint=HINT, explains=explained) if explained else None


def _never_stops(failed: Sequence[str], answered: Sequence[Answer]) -> Evidence | None:
    """Return the order of the comparisons, if the slow speed is the slowest of all."""
    near = {round(answer.speed or 0, 3) for answer in answered if _nearest(answer, _right) < STOP}
    slow = {round(each.speed or 0, 3) for each in answered if STOP <= _nearest(each, _right) < SLOW}
    stop = [check for check in failed if check in STOPS]
    if not stop or len(near) != 1 or near != slow or near == {0.0}:
        return None
    return Evidence(NEVER_STOPS.format(speed=near.pop()), hint="3.2", explains=stop)


def follows(answered: Sequence[Answer], sees: Sector) -> bool:
    """Return whether the speed follows the smallest distance in a sector, and does change."""
    rows = sorted((_nearest(answer, sees), answer.speed or 0.0) for answer in answered)
    distances, speeds = np.array(rows).T
    if np.ptp(speeds) < SAME:
        return False
    highest = np.maximum.accumulate(speeds)
    return bool(np.all(speeds >= highest - SAME)) and _same_for_same(distances, speeds)


def _same_for_same(distances: Floats, speeds: Floats) -> bool:
    """Return whether the same distance always gave the same speed."""
    near = np.diff(distances) < SAME
    return bool(np.all(np.abs(np.diff(speeds)[near]) < SAME))


def _nearest(answer: Answer, sees: Sector) -> float:
    scan = answer.scan
    angles = scan.first_angle + scan.angle_increment * np.arange(len(scan.ranges), dtype=float)
    degrees = (np.degrees(angles) + 180.0) % 360.0 - 180.0
    ranges = scan.ranges[sees(degrees)].astype(float)
    ranges[np.isneginf(ranges)] = 0.0
    ranges = ranges[np.isfinite(ranges)]
    return round(float(ranges.min()), 3) if ranges.size else float(scan.range_max)
