"""What no closing speed, or always the same one, says of the memory: for exercise 4."""

from __future__ import annotations

from collections.abc import Sequence

from grader.checks.commands import published
from grader.checks.verdict import Evidence, Trials
from grader.exercises.trend_memory.contract import SIZE, TOPIC
from sim.messages import FLOAT64

EXPLAINS = ("closing_speed", "one_speed_per_reading", "uses_stamps", "forgets_old", "looks_ahead",
            "stops_in_time", "unusable_scans", "clears_backwards", "clears_jump")  # fmt: skip
LEAST = 5  # closing speeds that are 0 without a digit


def seen(trials: Trials, failed: Sequence[str]) -> Evidence | None:
    """Return that the memory never seems to be full, or all its stamps seem to be one."""
    explained = [check for check in failed if check in EXPLAINS]
    runs = [run for run in trials.values() if run.outcome.completed and len(run.scans()) > 2 * SIZE]
    found = [float(said.data) for run in runs for _, said in published(run, TOPIC, FLOAT64)]
    if not explained or not runs:
        return None
    if not found:
        return Evidence(
            f"not one message comes on {TOPIC}. Does the callback get as far as its publish()? If "
            "so, does the memory ever hold ten readings, or is it emptied at each scan, as if "
            "stamps jumped? Two stamps differ by 0.1, in seconds (sec + nanosec / 1e9).",
            explains=explained,
        )
    if len(found) >= LEAST and not any(found):
        return Evidence(
            f"all {len(found)} closing speeds are exactly 0. Are the ten stamps different numbers, "
            "and the ten distances? A float32 keeps seven digits and a stamp has ten before the "
            "point: use Python's float.",
            explains=explained,
        )
    return None
