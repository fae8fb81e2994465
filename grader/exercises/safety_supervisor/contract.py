"""The oracle of safety_supervisor: what its rules ask for at each command that it published."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import pairwise, product
from typing import Literal, NamedTuple

import numpy as np

from grader.checks.ahead import HAIR, HALF_ANGLES, front_distance
from grader.checks.commands import FIELDS, ZERO
from grader.checks.contract import Contract, Limits, Survived, free_from
from grader.recording import Recording, Scan
from sim.messages import BOOL, CMD_VEL_RAW_TOPIC, E_STOP_TOPIC, TWIST, decode, twist_from_cdr
from sim.scenario import Scenario

LONGEST_SILENCE = 0.5  # [s]
AGE_HAIR = 0.05  # [s] ages this near to the limit may fall on either side
ARRIVAL_HAIR = 0.005  # [s] what arrived this shortly before a tick may count or not
STOP_DISTANCE = 0.5  # [m]
MAX_SPEED = 0.5  # [m/s]
MAX_TURN_RATE = 1.9  # [rad/s]
MAX_RISE = 0.045  # [m/s] of linear.x in a tick
SILENCE = 0.3  # [s] without a command, after which the last one is judged again at each tick
PERIOD = 0.05  # [s]
LATELY = 4  # commands
SETTLED = 0.6  # [s] in which a speed is reached, up or down, with 0.9 m/s²
TOLERANCE = 1e-3  # [m/s, rad/s] of a command that should not be zero

LEVELS = {  # of diagnostic_msgs/DiagnosticStatus: 0 OK, 1 WARN, 2 ERROR
    "e_stop": 2,
    "bad_command": 2,
    "stale_command": 2,
    "stale_scan": 2,
    "obstacle": 1,
    "limited": 1,
    "ok": 0,
}

STOPS = ("e_stop", "bad_command", "stale_command", "stale_scan")
HOLDS = (*STOPS, "obstacle")

MOVING = 0.1  # [m/s] what asks for less may stand


def _asked_to_go(scenario: Scenario, scan: Scan) -> bool:
    asked = [stream for stream in scenario.raw if stream.begin <= scan.t < stream.end]
    pressed = [event.e_stop for event in scenario.script if event.at <= scan.t]
    if not asked or not math.isfinite(asked[-1].linear_x) or (pressed and pressed[-1]):
        return False
    return asked[-1].linear_x >= MOVING and free_from(0.55)(scenario, scan)


CONTRACT = Contract(
    limits=Limits(slowest=-0.5, turning=1.9, rise=0.045),
    period=0.05,
    free=_asked_to_go,
    heeds_e_stop=True,
    supervises=True,
    search_for=8.0,
    delayed_in=("safe_drive",),
    survives=Survived(sensors=300, commands=300),
)


@dataclass(frozen=True)
class Decision:
    """One right command, and the reason for it."""

    reason: str
    speed: float = 0.0  # [m/s]
    turn_rate: float = 0.0  # [rad/s]
    wish: float = 0.0  # [m/s] the speed that the acceleration limit may hold back
    last: float = 0.0  # [m/s] of the command before; 0 if that drove backwards

    @property
    def rising(self) -> bool:
        """The acceleration limit holds it back."""
        return self.wish > self.speed

    def allows(
        self, speed: float, turn_rate: float, *, faster: bool = False, slower: bool = False
    ) -> bool:
        """Tell whether these are the right speed [m/s] and turn rate [rad/s].

        With `faster` and `slower`, a speed that rises faster or slower than it may is right as
        well: that is one mistake, and it has a check of its own.
        """
        if slower or (faster and self.rising):
            low = min(self.last, self.speed) if slower else self.speed
            high = max(self.wish, self.speed) if faster else self.speed
            fits = low - TOLERANCE <= speed <= high + TOLERANCE
        else:
            fits = _same(speed, self.speed, exact=self.reason in HOLDS)
        return fits and _same(turn_rate, self.turn_rate, exact=self.reason in STOPS)

    @property
    def gets_faster(self) -> bool:
        """It drives forwards, and faster than the command before."""
        return self.wish > self.last

    @property
    def moves(self) -> bool:
        """It drives or turns."""
        return self.speed != 0.0 or self.turn_rate != 0.0


@dataclass(frozen=True)
class Situation:
    """What the node had been sent by some time; the age of what had not come is inf."""

    e_stop: bool
    asked: tuple[float, ...] | None  # six fields of the last raw command
    command_age: float  # [s]
    distances: tuple[float | None, ...]  # [m] ahead, one for each of HALF_ANGLES; inf free
    scan_age: float  # [s]

    @property
    def asks_to_move(self) -> bool:
        """The last raw command was none to stand."""
        return self.asked is None or any(self.asked)

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


class Habit(NamedTuple):
    """What a node does always, right or wrong: see `habits.py`."""

    pressed: Literal["true", "any", "at first"] = "true"  # the button is, after which messages
    held: bool = False  # it decides when a scan comes, and until the next one repeats that


AS_ASKED = Habit()


@dataclass(frozen=True)
class Tick:
    """A command that the node published, and what would have been right."""

    t: float  # [s]
    values: tuple[float, ...]  # six fields
    situation: Situation
    right: tuple[Decision, ...]
    matching: tuple[str, ...]  # every rule that matches, in the order of the rules
    same_for: float  # [s] since the model began to ask for what it asks for
    rising_lately: bool = False  # here, or at one of the commands before

    @property
    def reasons(self) -> set[str]:
        """The reasons that are right here."""
        return {decision.reason for decision in self.right}

    @property
    def is_right(self) -> bool:
        """Speed and turn rate are right."""
        return any(decision.allows(self.values[0], self.values[5]) for decision in self.right)

    @property
    def is_exact(self) -> bool:
        """Speed and turn rate are right, and so near that ok and limited are told apart."""
        speed, turn_rate = self.values[0], self.values[5]
        return self.is_right and any(
            abs(speed - d.speed) < ZERO and abs(turn_rate - d.turn_rate) < ZERO for d in self.right
        )

    @property
    def rising(self) -> bool:
        """Here linear.x should rise, and the acceleration limit holds it back."""
        return any(decision.rising for decision in self.right)

    @property
    def stops(self) -> set[str]:
        """The reasons among those that are right here that make the robot stand."""
        return self.reasons.intersection(STOPS)

    @property
    def is_right_but_for_the_rise(self) -> bool:
        """Speed and turn rate are right, or would be if it might get faster as it likes.

        Faster or more slowly than it may, but not: not at all.
        """
        speed, turn_rate = self.values[0], self.values[5]
        slower = self.rising_lately and speed > ZERO
        return any(
            d.allows(speed, turn_rate, faster=True, slower=slower and d.gets_faster)
            for d in self.right
        )

    @property
    def must_move(self) -> bool:
        """No command is right that leaves the robot standing."""
        return all(decision.moves for decision in self.right)

    @property
    def moves(self) -> bool:
        """The command is one to drive or to turn; never true of NaN."""
        return abs(self.values[0]) >= ZERO or abs(self.values[5]) >= ZERO


def is_settled(tick: Tick) -> bool:
    """Tell whether what is asked for has been the same for long enough to be reached."""
    return tick.same_for >= SETTLED


def never_reverses(tick: Tick, recording: Recording) -> bool:
    """Tell whether a command is right but for a 0.0 where it should drive backwards.

    A node that never reverses makes one mistake, and `passes_on` is there for it. One that does
    reverse in this recording is late here.
    """
    if bool((recording.twists().values[:, 0] < -ZERO).any()):
        return False
    speed, turn_rate = tick.values[0], tick.values[5]
    return abs(speed) <= ZERO and any(
        decision.speed < 0.0 and decision.allows(decision.speed, turn_rate)
        for decision in tick.right
    )


@lru_cache(maxsize=32)  # nearly every check asks; 25 different questions in all
def ticks(
    recording: Recording, *, silences: bool = False, habit: Habit = AS_ASKED
) -> tuple[Tick, ...]:
    """Return every command that the node published, with what was right.

    Or what would be right of a node that has another habit.

    With `silences` also each tick at which it should have published one, and had been silent for
    long: its last command is still in force. Otherwise a node that drives off and falls silent
    would do nothing wrong any more.
    """
    arrivals = _Arrivals(recording, habit)
    hair = ARRIVAL_HAIR + recording.slack
    begins = np.array([0.0, *(stream.begin for stream in recording.scenario.raw)])
    found: list[Tick] = []
    last = 0.0  # [m/s] linear.x of the command before
    for t, row in _in_force(recording, silences):
        now, *others = arrivals.known(t, hair)
        right = [right for known in (now, *others) for right in _decisions(known, last)]
        same_for = t - float(begins[begins <= t].max())
        matching = tuple(_matching(now))
        rising = any(d.rising for d in right) or any(tick.rising for tick in found[-LATELY:])
        alike = tuple(dict.fromkeys(right))
        found.append(Tick(t, tuple(row), now, alike, matching, same_for, rising))
        last = row[0] if math.isfinite(row[0]) else 0.0
    return tuple(found)


def _in_force(recording: Recording, silences: bool) -> Iterator[tuple[float, list[float]]]:
    """Yield the times [s] and fields of commands, and those in force during silences."""
    twists = recording.twists()
    times = [*twists.t.tolist(), recording.duration_s]
    for (t, end), row in zip(pairwise(times), twists.values.tolist(), strict=True):
        yield t, row
        if silences:
            for tick in np.arange(t + SILENCE + recording.slack, end, PERIOD).tolist():
                yield tick, row


class _Arrivals:
    """What the node was sent, and when."""

    def __init__(self, recording: Recording, habit: Habit) -> None:
        self.habit = habit
        delivered = recording.delivered
        raw = [m for m in delivered if m.topic == CMD_VEL_RAW_TOPIC and m.type == TWIST]
        stops = [m for m in delivered if m.topic == E_STOP_TOPIC and m.type == BOOL]
        self.raw_times = np.array([m.time / 1e9 for m in raw])
        self.raw = [twist_from_cdr(m.data) for m in raw]
        self.stop_times = np.array([m.time / 1e9 for m in stops])
        self.stops = [bool(decode(m.data, BOOL).data) for m in stops]
        self.scan_times = np.array([scan.t for scan in recording.scans()])
        self.distances = [_distances(scan) for scan in recording.scans()]

    def known(self, t: float, hair: float) -> Iterator[Situation]:
        """Yield what a node may decide by at t [s]: what arrives within a hair [s] may count."""
        for arrived in (t, t - hair):
            scan = int(np.searchsorted(self.scan_times, arrived, side="right")) - 1
            if not self.habit.held or scan < 0:
                yield self.at(arrived, age_at=t)
                continue
            then = float(self.scan_times[scan])
            for too_old in _too_old(t - then):
                if too_old:
                    yield self.at(arrived, age_at=t)
                else:
                    seen = self.at(then)
                    before = self.at(then - hair, age_at=then)
                    yield seen
                    yield replace(before, distances=seen.distances, scan_age=seen.scan_age)

    def at(self, t: float, age_at: float | None = None) -> Situation:
        """Return what had arrived by t [s], with ages as they are at `age_at`."""
        now = t if age_at is None else age_at
        raw, stop, scan = (
            int(np.searchsorted(times, t, side="right")) - 1
            for times in (self.raw_times, self.stop_times, self.scan_times)
        )
        return Situation(
            e_stop=self._is_pressed(stop),
            asked=self.raw[raw] if raw >= 0 else None,
            command_age=now - float(self.raw_times[raw]) if raw >= 0 else math.inf,
            distances=self.distances[scan] if scan >= 0 else (),
            scan_age=now - float(self.scan_times[scan]) if scan >= 0 else math.inf,
        )

    def _is_pressed(self, stop: int) -> bool:
        """Tell whether the button is pressed for the node, `stop` being the newest /e_stop."""
        if stop < 0:
            return self.habit.pressed == "at first"
        return self.habit.pressed == "any" or self.stops[stop]


def _distances(scan: Scan) -> tuple[float | None, ...]:
    return tuple(front_distance(scan, half_angle) for half_angle in HALF_ANGLES)


def _decisions(situation: Situation, last: float) -> Iterator[Decision]:
    """Yield what is right after a last speed [m/s]; several where a limit is too near to tell."""
    asked = situation.asked
    if situation.e_stop:
        yield Decision("e_stop")
        return
    if asked is not None and not all(math.isfinite(value) for value in asked):
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


def _matching(situation: Situation) -> Iterator[str]:
    """Yield every rule that matches; `limited` only where more is asked for than ever goes out."""
    asked, distances = situation.asked, situation.distances
    bad = asked is not None and not all(math.isfinite(value) for value in asked)
    if situation.e_stop:
        yield "e_stop"
    if bad:
        yield "bad_command"
    if situation.command_age > LONGEST_SILENCE:
        yield "stale_command"
    if situation.scan_age > LONGEST_SILENCE or all(d is None for d in distances):
        yield "stale_scan"
    if asked is None or bad:
        return
    if asked[0] > 0.0 and any(_is_near(d) for d in distances):
        yield "obstacle"
    if abs(asked[0]) > MAX_SPEED or abs(asked[5]) > MAX_TURN_RATE:
        yield "limited"


def _is_near(distance: float | None) -> bool:
    return distance is not None and distance < STOP_DISTANCE


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
    turn_rate = min(max(asked_turn_rate, -MAX_TURN_RATE), MAX_TURN_RATE)
    hair = 0.0 < abs(distance - STOP_DISTANCE) < HAIR
    if asked_speed > 0.0 and (distance < STOP_DISTANCE or hair):
        yield Decision("obstacle", 0.0, turn_rate)
        if not hair:
            return
    fastest = max(0.0, last) + MAX_RISE
    clamped = min(max(asked_speed, -MAX_SPEED), MAX_SPEED)
    speed = min(clamped, fastest)
    as_asked = speed == asked_speed and turn_rate == asked_turn_rate
    right = Decision("ok" if as_asked else "limited", speed, turn_rate, clamped, max(0.0, last))
    yield right
    if abs(fastest - asked_speed) < TOLERANCE and turn_rate == asked_turn_rate:
        yield replace(right, reason="limited" if as_asked else "ok")


def _same(value: float, wanted: float, *, exact: bool) -> bool:
    """Tell whether a number is right; where a rule makes it zero, it has to be exactly that."""
    return abs(value - wanted) <= (ZERO if exact and wanted == 0.0 else TOLERANCE)
