"""How a node commands what its model says, right or wrong: a mistake is named, and paid for, once.

`readings` fails for a node whose commands are all a bit off, or that exchanges two features, and
`onnx` for one that puts an np.float32 into linear.x, or that no ONNX model drives. Other checks
take that as given.
"""

from __future__ import annotations

from collections.abc import Iterable
from itertools import combinations

from grader.checks.verdict import passes
from grader.exercises.model_formats.contract import ORDER, is_onnx
from grader.exercises.model_formats.evidence import RIGHT, Habits, require_speeds
from grader.models.features import NAMES
from grader.recording import Recording

READINGS, WITH_ONNX = "format_readings", "format_onnx"  # scenarios that show a node's habits
HABITS = (READINGS, WITH_ONNX)
LONG = "format_hundred"  # 700 scans, 40 a second
NEARLY = 6e-3  # [m/s] more than rounding to two decimals changes
_EXCHANGED = tuple(
    tuple(b if i == a else a if i == b else i for i in ORDER) for a, b in combinations(ORDER, 2)
)


def habits_of(readings: Recording, onnx: Recording | None = None) -> Habits:
    """Return how a node commands what its model says; `onnx` shows what type its numbers have."""
    known = (RIGHT, Habits(NEARLY), *(Habits(order=order) for order in _EXCHANGED))
    found = next(
        (habits for habits in known if passes(require_speeds, readings, habits=habits)), RIGHT
    )
    narrow = found._replace(narrow=True)
    if (
        onnx is None
        or passes(require_speeds, onnx, habits=found)
        or not passes(require_speeds, onnx, habits=narrow)
    ):
        return found
    return narrow


def driven(runs: Iterable[Recording], onnx: Recording, habits: Habits) -> list[Recording]:
    """Return those of these runs whose model drives the node: all, unless `onnx` has failed.

    If no ONNX model does, whatever it says, a pickle shows as well what the node makes of it.
    """
    follows = passes(require_speeds, onnx, habits=habits)
    return [run for run in runs if follows or not is_onnx(run)]


def slip(habits: Habits) -> str:
    """Return what is wrong with the commands that a node made of its readings; else nothing."""
    if habits.tolerance == NEARLY:
        return (
            "All commands are near what the model says, and not equal to it: is a number rounded?"
        )
    moved = [NAMES[place] for place in ORDER if habits.order[place] != place]
    return f"All commands fit if {' and '.join(moved)} change places." if moved else ""
