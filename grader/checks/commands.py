"""What a node publishes on /cmd_vel: which Twist answers which scan, and the Twist's fields."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grader.checks.ahead import front_distance
from grader.checks.turns import turns
from grader.recording import Floats, Recording, Scan

FIELDS = ("linear.x", "linear.y", "linear.z", "angular.x", "angular.y", "angular.z")
WATCHDOG = 0.45  # [s] without a scan, after which a zero Twist stops the robot
ZERO = 1e-6  # [m/s, rad/s] a field nearer to 0 than this is zero


@dataclass(frozen=True)
class Answer:
    """A scan and the command in force when the next scan came."""

    scan: Scan
    label: str  # of a bench scan; empty in a closed loop
    tags: tuple[str, ...]
    count: int  # commands between this scan and the next
    twist: Mapping[str, float]  # in force [m/s, rad/s], by FIELDS; empty: there has been none yet

    @property
    def speed(self) -> float | None:
        """`linear.x` in force [m/s]; None: there has been no command yet."""
        return self.twist.get("linear.x")

    def said(self, *fields: str) -> dict[str, float]:
        """Return these fields of the command in force, as a case has them."""
        return {name: self.twist[name] for name in fields if self.twist}

    @property
    def what(self) -> str:
        """The scan in words, for a student."""
        if self.label:
            return f"“{self.label}”"
        distance = front_distance(self.scan)
        return "a scan with nothing usable ahead" if distance is None else f"{distance:.2f} m ahead"


def answers(recording: Recording) -> list[Answer]:
    """Return each scan that was sent, with the node's answer to it.

    What stops the robot once no scan has come for a while is a watchdog's, and no answer.
    """
    twists, bench = recording.twists(), recording.scenario.bench_scans
    zero = np.all(is_zero(twists.values), axis=1)
    scans, first = turns(recording)
    found = []
    for i, scan in enumerate(scans):
        begin, end = int(first[i]), int(first[i + 1])
        while end > begin + 1 and zero[end - 1] and twists.t[end - 1] > scan.t + WATCHDOG:
            end -= 1
        found.append(
            Answer(
                scan=scan,
                label=bench[i].label if bench else "",
                tags=bench[i].tags if bench else (),
                count=end - begin,
                twist=dict(zip(FIELDS, twists.values[end - 1].tolist(), strict=True))
                if end
                else {},
            )
        )
    return found


def is_zero(numbers: Floats) -> NDArray[np.bool_]:
    """Return which numbers of commands are zero; NaN is not."""
    zero: NDArray[np.bool_] = np.abs(numbers) < ZERO
    return zero


def spell(value: float) -> str:
    """Return a command's number as a student should see it, with two to four decimals."""
    if 0.0 < abs(value) < 0.005:
        return f"{value:.3g}"
    if not abs(value) < 100.0:
        return f"{value:.2f}"
    whole, decimals = f"{value:.4f}".split(".")
    return f"{whole}.{decimals.rstrip('0').ljust(2, '0')}"


def garbage(value: float) -> str:
    """Return an explanation if a number can only be a wrongly typed field; else an empty text."""
    if math.isnan(value) or 0.0 < abs(value) < 1e-300 or 1e6 < abs(value) < math.inf:
        return (
            "This number is garbage: the field holds an int or a np.float32 where ROS wants a "
            "Python float. Write float(…) around what you assign."
        )
    return ""
