"""How a node takes delays, as a table for the terminal."""

from __future__ import annotations

from grader.checks.contract import Survived
from grader.drive.delay import AXES, DELAYS, SENSORS, Delays, Tried

BAR = 20  # [characters]
NAMES = {SENSORS: "scans and odometry", "commands": "commands"}


def table(result: Delays, reference: Survived | None) -> list[str]:
    """Return a bar for each delay, the numbers, and what the reference survives."""
    most = max(one.margin for axis in AXES for one in result.tried[axis]) or 1.0
    lines = []
    for axis in AXES:
        rows = (_line(one, most, result.unit) for one in result.tried[axis])
        lines += [f"Late {NAMES[axis]}", *rows, ""]
    return [*lines, *(_sentence(result.survived, reference, axis) for axis in AXES)]


def _sentence(survived: Survived, reference: Survived | None, axis: str) -> str:
    beside = f" (the reference: {_amount(reference.of(axis))})" if reference else ""
    if survived.of(axis) < 0:
        return f"Survives no late {NAMES[axis]}{beside}: it fails without any delay."
    return f"Survives {NAMES[axis]} that are late by {_amount(survived.of(axis))}{beside}."


def _amount(delay: int) -> str:
    if delay < 0:
        return "none"
    return f"{delay} ms, the most tried" if delay == DELAYS[-1] else f"{delay} ms"


def _line(one: Tried, most: float, unit: str) -> str:
    if one.mishap is not None:
        return f"  {one.delay:3d} ms  {one.failed}"
    bar = "#" * max(1, round(BAR * one.margin / most))
    return f"  {one.delay:3d} ms  {bar:<{BAR}}  {one.margin:.2f} {unit}  {one.where}"
