"""Which beams a node reacts to, from its answers to bench scans: for exercise 1.

A node that perceives rightly may still decide wrongly; but its speed never falls as the distance
that it sees grows. So the right sector, and each wrong one, is tried: does the speed follow the
smallest distance in it, in every scan? If several do, or the right one does, nothing is said.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from grader.checks.commands import Answer, answers
from grader.checks.verdict import Evidence, Trials

BENCH = "avoid_zones"
SAME = 1e-3  # [m/s], [m]
LEAST = 12  # scans with an answer
EDGE = 0.25  # [°] a beam's angle is a float32
UNSEEN = ("wiring", "one_command_per_scan", "only_linear_x", "callback_time")  # of no sector

Sector = tuple[float, float]  # [°] where its middle is, positive to the left, and half its width
AHEAD: Sector = (0.0, 90.0)
CONES = (2, *range(10, 85, 5))  # [°] half of one
MISTAKES: dict[Sector, str] = {
    (180.0, 90.0): "behind the robot, and not ahead. This lidar's first beam looks backwards "
    "(angle_min = -π): is it taken for straight ahead?",
    (0.0, 180.0): "anywhere around the robot, also behind it; only ±90° of ahead count. Is every "
    "beam's angle compared, and in radians (π/2, not 90)?",
    (90.0, 90.0): "on the robot's left, ahead and behind: ahead is -90° … 90°, not 0° … 180°.",
    (-90.0, 90.0): "on the robot's right, ahead and behind: ahead is -90° … 90°.",
    (180.0, EDGE): "in the first beam, which points backwards (angle_min = -π). Look at every beam "
    "within ±90° of ahead.",
}
NARROW = (
    "straight ahead, in hardly more than one beam. Does it look at one beam only, or compare "
    "degrees with radians? Everything within ±90° (π/2) counts."
)


def seen(trials: Trials, failed: Sequence[str]) -> Evidence | None:
    """Return which wrong sector explains all the node's answers, if the right one doesn't."""
    bench = trials.get(BENCH)
    explained = [check for check in failed if check not in UNSEEN]
    if bench is None or not bench.outcome.completed or not explained:
        return None
    answered = [answer for answer in answers(bench) if answer.speed is not None]
    if len(answered) < LEAST or follows(answered, AHEAD):
        return None
    texts = [text for sector, text in MISTAKES.items() if follows(answered, sector)]
    if cones := [half for half in CONES if follows(answered, (0.0, half))]:
        wide = f"within about ±{cones[-1]}° of ahead; everything within ±90° counts."
        texts.append(NARROW if cones[0] == CONES[0] else wide)
    if len(texts) != 1:
        return None
    text = f"in all {len(answered)} scans of {BENCH} the speed follows the nearest thing {texts[0]}"
    return Evidence(text, hint="3.1", explains=explained)


def follows(answered: Sequence[Answer], sector: Sector) -> bool:
    """Return whether the speed follows the smallest distance in a sector, and does change."""
    middle, half = sector
    return any(_rises(answered, middle, half + edge) for edge in (EDGE, -EDGE))


def _rises(answered: Sequence[Answer], middle: float, half: float) -> bool:
    """Return whether the speed never falls with the distance, and is one for each distance."""
    rows = sorted((_nearest(answer, middle, half), answer.speed or 0.0) for answer in answered)
    steps = np.diff(np.array(rows), axis=0)
    same = steps[:, 0] < SAME
    return bool(
        np.ptp([speed for _, speed in rows]) >= SAME
        and np.all(steps[:, 1] >= -SAME)
        and np.all(np.abs(steps[same, 1]) < SAME)
    )


def _nearest(answer: Answer, middle: float, half: float) -> float:
    scan = answer.scan
    off = (np.degrees(scan.angles) - middle + 180.0) % 360.0 - 180.0
    ranges = scan.ranges[np.abs(off) <= half].astype(float)
    ranges[np.isneginf(ranges)] = 0.0
    ranges = ranges[np.isfinite(ranges)]
    return round(float(ranges.min()), 3) if ranges.size else float(scan.range_max)
