"""The rules of safety_supervisor: which decisions are right, given what a node has been sent."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product

from grader.checks.ahead import HAIR
from grader.checks.commands import FIELDS

LONGEST_SILENCE = 0.5  # [s]
AGE_HAIR = 0.05  # [s] ages this near to the limit may fall on either side
STOP_DISTANCE = 0.5  # [m]
MAX_SPEED = 0.5  # [m/s]
MAX_TURN_RATE = 1.9  # [rad/s]
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
    asked: tuple[float, ...] | None  # six fields of the last raw command
    command_age: float  # [s]
    distances: tuple[float | None, ...]  # [m] ahead, one for each of HALF_ANGLES; inf free
    scan_age: float  # [s]

    @property
    def is_bad(self) -> bool:
        """The last raw command has a field that is not finite."""
        return self.asked is not None and not all(map(math.isfinite, self.asked))

    @property
    def what(self) -> str:
        """The situation in words, for a student."""
        parts = ["the emergency stop is pressed"] if self.e_stop else []
        if self.asked is None:
            parts.append("no raw command yet")
        else:
            v, w = self.asked[0], self.asked[5]
            others = zip(FIELDS[1:5], self.asked[1:5], strict=True)
            too = "".join(f", {name} {value:.2f}" for name, value in others if value != 0.0)
            parts.append(f"asked for {v:.3g} m/s, {w:.3g} rad/s{too} {self.command_age:.2f} s ago")
        if not self.distances:
            parts.append("no scan yet")
        else:
            d = self.distances[0]
            ahead = "nothing usable ahead" if d is None else f"{d:.2f} m ahead"
            parts.append(f"{ahead} {self.scan_age:.2f} s ago")
        return "; ".join(parts)

    def matching(self) -> list[str]:
        """Return every rule that matches but `ok`; `limited` is for what is asked, not its rise."""
        asked = self.asked if self.asked is not None and not self.is_bad else (0.0,) * 6
        near = any(d is not None and d < STOP_DISTANCE for d in self.distances)
        matches = {
            "e_stop": self.e_stop,
            "bad_command": self.is_bad,
            "stale_command": self.command_age > LONGEST_SILENCE,
            "stale_scan": self.scan_age > LONGEST_SILENCE or set(self.distances) <= {None},
            "obstacle": asked[0] > 0.0 and near,
            "limited": abs(asked[0]) > MAX_SPEED or abs(asked[5]) > MAX_TURN_RATE,
        }
        return [reason for reason, match in matches.items() if match]


def decisions(situation: Situation, last: float) -> Iterator[Decision]:
    """Yield what is right after a last speed [m/s]; several where a limit is too near to tell."""
    asked = situation.asked
    if situation.e_stop:
        yield Decision("e_stop")
        return
    if situation.is_bad:
        yield Decision("bad_command")
        return
    choices = product(_too_old(situation.command_age), _too_old(situation.scan_age))
    for stale_command, stale_scan in choices:
        if stale_command or asked is None:
            yield Decision("stale_command")
        elif stale_scan:
            yield Decision("stale_scan")
        else:
            for distance in dict.fromkeys(situation.distances):
                yield from _moving(distance, asked[0], asked[5], last)


def _too_old(age: float) -> tuple[bool, ...]:
    if abs(age - LONGEST_SILENCE) < AGE_HAIR:
        return True, False
    return (age > LONGEST_SILENCE,)


def _moving(
    distance: float | None, asked_speed: float, asked_turn_rate: float, last: float
) -> Iterator[Decision]:
    if distance is None:
        yield Decision("stale_scan")
        return
    turn_rate = _clamp(asked_turn_rate, MAX_TURN_RATE)
    hair = 0.0 < abs(distance - STOP_DISTANCE) < HAIR
    if asked_speed > 0.0 and (distance < STOP_DISTANCE or hair):
        yield Decision("obstacle", 0.0, turn_rate)
        if not hair:
            return
    fastest = max(0.0, last) + MAX_RISE
    clamped = _clamp(asked_speed, MAX_SPEED)
    speed, rising = min(clamped, fastest), clamped > fastest
    as_asked = speed == asked_speed and turn_rate == asked_turn_rate
    yield Decision("ok" if as_asked else "limited", speed, turn_rate, rising)
    if abs(fastest - asked_speed) < TOLERANCE and turn_rate == asked_turn_rate:
        yield Decision("limited" if as_asked else "ok", speed, turn_rate, rising)


def _clamp(value: float, limit: float) -> float:
    return min(max(value, -limit), limit)
