"""The rules of safety_supervisor: which decisions are right, given what a node has been sent."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

from grader.checks.ahead import HAIR
from grader.checks.commands import FIELDS

LONGEST_SILENCE = 0.5  # [s]
AGE_HAIR = 0.05  # [s] ages this near to the limit may fall on either side
STOP_DISTANCE = 0.5  # [m]
LIMITS = MAX_SPEED, MAX_TURN_RATE = 0.5, 1.9  # [m/s] and [rad/s]
MAX_RISE = 0.045  # [m/s] of linear.x in a tick
TOLERANCE = 1e-3  # [m/s] of a speed that is just as asked, or just limited

STOPS = ("e_stop", "bad_command", "stale_command", "stale_scan")
PASSES_ON = ("limited", "ok")


@dataclass(frozen=True)
class Decision:
    """One right command, and the reason for it."""

    reason: str
    speed: float = 0.0  # [m/s]
    turn_rate: float = 0.0  # [rad/s]
    rising: bool = False  # linear.x gets faster, and the acceleration limit holds it back


@dataclass(frozen=True)
class Situation:
    """What a node had been sent by some time; the age of what had not come is inf."""

    e_stop: bool
    raw: tuple[float, ...] | None  # six fields of the last raw command
    command_age: float  # [s]
    distances: tuple[float | None, ...]  # [m] ahead, one for each of HALF_ANGLES; inf free
    scan_age: float  # [s]

    @cached_property
    def is_bad(self) -> bool:
        """The last raw command has a field that is not finite."""
        return self.raw is not None and not all(map(math.isfinite, self.raw))

    @cached_property
    def asked(self) -> tuple[float, float]:
        """What a usable command asks for [m/s, rad/s]."""
        return (0.0, 0.0) if self.raw is None or self.is_bad else (self.raw[0], self.raw[5])

    @property
    def what(self) -> str:
        """The situation in words, for a student."""
        parts = ["the emergency stop is pressed"] if self.e_stop else []
        if self.raw is None:
            parts.append("no raw command yet")
        else:
            named = zip(FIELDS, self.raw, strict=True)
            asked = ", ".join(f"{name} {value:.3g}" for name, value in named if value != 0.0)
            parts.append(f"asked for {asked or 'zero'} {self.command_age:.2f} s ago")
        if not self.distances:
            parts.append("no scan yet")
        else:
            d = self.distances[0]
            ahead = "nothing usable ahead" if d is None else f"{d:.2f} m ahead"
            parts.append(f"{ahead} {self.scan_age:.2f} s ago")
        return "; ".join(parts)


def matching(situation: Situation, fastest: float = math.inf) -> dict[str, set[bool]]:
    """Return whether each rule matches, in their order; both where a limit is too near to tell.

    `fastest` is what linear.x may rise to [m/s].
    """
    speed, turn_rate = situation.asked
    blind = {distance is None for distance in situation.distances} or {True}
    near = {n for d in situation.distances if d is not None for n in _is_near(d)}
    clamped = abs(speed) > MAX_SPEED or abs(turn_rate) > MAX_TURN_RATE
    rising = {True, False} if abs(speed - fastest) < TOLERANCE else {speed > fastest}
    stale = _is_old(situation.command_age) if situation.raw is not None else {True}
    return {
        "e_stop": {situation.e_stop},
        "bad_command": {situation.is_bad},
        "stale_command": stale,
        "stale_scan": {old or b for old in _is_old(situation.scan_age) for b in blind},
        "obstacle": {speed > 0.0 and n for n in near or {False}},
        "limited": {clamped or r for r in rising},
        "ok": {True},
    }


def decisions(situation: Situation, last: float) -> Iterator[Decision]:
    """Yield what is right after a last speed [m/s]; several where a limit is too near to tell."""
    fastest = max(0.0, last) + MAX_RISE
    speed, turn_rate = (_clamp(*pair) for pair in zip(situation.asked, LIMITS, strict=True))
    for reason, matches in matching(situation, fastest).items():
        if True in matches and reason in STOPS:
            yield Decision(reason)
        elif True in matches and reason == "obstacle":
            yield Decision(reason, 0.0, turn_rate)
        elif True in matches:
            yield Decision(reason, min(speed, fastest), turn_rate, speed > fastest)
        if matches == {True}:
            return


def _clamp(value: float, limit: float) -> float:
    return min(max(value, -limit), limit)


def _is_old(age: float) -> set[bool]:
    return {True, False} if abs(age - LONGEST_SILENCE) < AGE_HAIR else {age > LONGEST_SILENCE}


def _is_near(distance: float) -> set[bool]:
    hair = 0.0 < abs(distance - STOP_DISTANCE) < HAIR
    return {True, False} if hair else {distance < STOP_DISTANCE}
