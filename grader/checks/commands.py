"""What a node publishes on /cmd_vel: which Twist answers which scan, and the Twist's fields."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grader.checks.ahead import front_distance
from grader.checks.moments import first_asked
from grader.checks.turns import turns
from grader.checks.verdict import fail
from grader.checks.wiring import require_alive
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


def require_one_command_each(recording: Recording) -> None:
    """Fail unless exactly one command followed each scan, and none came before the first."""
    require_alive(recording)
    found, twists = answers(recording), recording.twists()
    if not found:
        fail("no scan was sent", recording=recording)
    if len(twists.t) and twists.t[0] < found[0].scan.t:
        fail(
            "a command came before the first scan",
            expected="silence until there is something to decide on",
            actual=f"a Twist at {twists.t[0]:.3f} s, the first scan at {found[0].scan.t:.3f} s",
            at=float(twists.t[0]),
            recording=recording,
            help="Publish from the scan callback only, not from the constructor or a timer.",
        )
    for answer in found:
        if answer.count != 1:
            fail(
                f"{answer.count} commands followed {answer.what}",
                expected="exactly one Twist for each scan",
                actual=f"{answer.count} between this scan and the next",
                at=answer.scan.t,
                recording=recording,
                help="Look for a timer, a second publish(), or a return before the publish().",
            )


def require_only_linear_x(recording: Recording, help: str) -> None:
    """Fail unless there are commands, and every field of them but linear.x is zero."""
    require_alive(recording)
    if not len(recording.twists().t):
        fail(
            "not a single Twist came on /cmd_vel",
            expected="one Twist for each scan",
            actual="nothing on /cmd_vel",
            at=first_asked(recording),
            recording=recording,
        )
    require_zero(recording, FIELDS[1:], help)


def require_zero(recording: Recording, fields: Iterable[str], help: str) -> None:
    """Fail unless these fields are zero in every command."""
    twists = recording.twists()
    for field in fields:
        numbers = twists.values[:, FIELDS.index(field)]
        wrong = np.flatnonzero(~is_zero(numbers))
        if len(wrong):
            value = float(numbers[wrong[0]])
            fail(
                f"{field} is not zero",
                expected=f"{field} = 0.0",
                actual=f"{field} = {spell(value)}",
                at=float(twists.t[wrong[0]]),
                recording=recording,
                help=garbage(value) or help,
            )


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
