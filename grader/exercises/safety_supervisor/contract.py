"""The oracle of safety_supervisor: what its rules ask for at each tick, and what was reported."""

from __future__ import annotations

import math
import re
from bisect import bisect_right
from collections.abc import Iterator, Sequence
from itertools import pairwise
from operator import itemgetter
from typing import TypeVar

import numpy as np

from grader.checks.ahead import front_distances
from grader.checks.case import Case, Said, exactly
from grader.checks.commands import ZERO, published
from grader.checks.contract import Contract, Limits, free_from
from grader.exercises.safety_supervisor.rules import (
    MAX_RISE,
    MAX_SPEED,
    MAX_TURN_RATE,
    PASSES_ON,
    STOPS,
    TOLERANCE,
    Decision,
    Situation,
    decisions,
    matching,
)
from grader.recording import Recording, Scan
from sim.messages import BOOL, CMD_VEL_RAW_TOPIC, E_STOP_TOPIC, decode, twist_from_cdr
from sim.scenario import Scenario

DIAGNOSTICS_TOPIC = "/diagnostics"
DIAGNOSTICS = "diagnostic_msgs/msg/DiagnosticArray"
LEVEL_NAMES = {0: "OK", 1: "WARN", 2: "ERROR", 3: "STALE"}
LEVELS = {**dict.fromkeys(STOPS, "ERROR"), "obstacle": "WARN", "limited": "WARN", "ok": "OK"}

PERIOD = 0.05  # [s] of a tick
ARRIVAL_HAIR = 0.005  # [s] what arrived this shortly before a tick may count or not
SILENCE = 0.3  # [s] without a command, after which the last one is judged again at each tick
SETTLED = 0.6  # [s] in which a speed is reached, and reasons are not judged after the start
MOVING = 0.1  # [m/s] what asks for less may stand
YES = frozenset({"yes"})
T = TypeVar("T")
Report = tuple[float, dict[str, Said]]  # when it came [s], and what it says: reason and level


def _asked_to_go(scenario: Scenario, scan: Scan) -> bool:
    asked = [stream for stream in scenario.raw if stream.begin <= scan.t < stream.end]
    pressed = [event.e_stop for event in scenario.script if event.at <= scan.t]
    if not asked or not math.isfinite(asked[-1].linear_x) or (pressed and pressed[-1]):
        return False
    return asked[-1].linear_x >= MOVING and free_from(0.55)(scenario, scan)


CONTRACT = Contract(
    limits=Limits(slowest=-MAX_SPEED, fastest=MAX_SPEED, turning=MAX_TURN_RATE, rise=MAX_RISE),
    period=PERIOD,
    free=_asked_to_go,
    heeds_e_stop=True,
    supervises=True,
    search_for=8.0,
)


def cases(recording: Recording) -> tuple[Case, ...]:
    """Return the occasions: at each tick a command and a reason, and each report.

    A command has as tags the reason for it, if only one is right; and

        rising    linear.x gets faster, and the acceleration limit holds it back
        slower    linear.x gets slower, or leads backwards
        settled   the same has been asked for long enough to be reached

    `moves` asks only that the robot doesn't stand, `rise` how fast it may get faster. A reason has
    `alone` or `first`: as one rule matches, or the first of several. A report has `report` for its
    form, and `level` with the level that its reason has.
    """
    reports = _reports(recording)
    return (*_ticks(recording, reports), *_forms(reports))


def _ticks(recording: Recording, reports: list[Report]) -> Iterator[Case]:
    """Yield the occasions of each tick: a command, and the reason that was given last."""
    sent = _Sent(recording)
    begins = [0.0, *(stream.begin for stream in recording.scenario.raw)]
    last = 0.0  # [m/s] linear.x of the command before
    before = frozenset[str]()  # the reasons of the last tick
    for t, row, count in _in_force(recording):
        now, earlier = sent.by(t, t), sent.by(t - ARRIVAL_HAIR - recording.slack, t)
        right, what = [*decisions(now, last)], now.what
        if earlier != now:  # something came in between
            right += decisions(earlier, last)
        reported = _newest(reports, t + ZERO)[1] or {}
        said = {**_command(row), **reported} if row else {}
        settled = t - max(begin for begin in begins if begin <= t) >= SETTLED
        tags = frozenset(_tags(right, last, settled=settled))
        speeds, turn_rates = {each.speed for each in right}, {each.turn_rate for each in right}
        allowed = {"linear.x": exactly(*speeds), "angular.z": exactly(*turn_rates)}
        yield Case(t, what, tags, allowed, said, count)
        if count:
            most = {"linear.x": ((-math.inf, max(0.0, last) + MAX_RISE + TOLERANCE),)}
            yield Case(t, what, frozenset({"rise"}), most, said)
        asked = {"driving": speeds, "turning": turn_rates}
        if moving := {name: YES for name, numbers in asked.items() if 0.0 not in numbers}:
            yield Case(t, what, frozenset({"moves", *LEVELS.keys() & tags}), moving, said)
        reasons = frozenset(each.reason for each in right)
        if t > SETTLED:  # a new reason is due at the next tick
            sure = [reason for reason, matches in matching(now).items() if matches == {True}]
            tag = "first" if len(sure) > 2 else "alone"  # "ok" is always among them
            yield Case(t, what, frozenset({tag}), {"reason": reasons | before}, reported)
        last, before = row[0] if row and math.isfinite(row[0]) else 0.0, reasons


def _tags(right: list[Decision], last: float, *, settled: bool) -> Iterator[str]:
    reasons = {decision.reason for decision in right}
    rising = any(decision.rising for decision in right)
    if len(reasons) == 1:
        yield from reasons
    if settled and not rising:
        yield "settled"
    if reasons.issubset(PASSES_ON):
        if rising:
            yield "rising"
        if all(decision.speed < max(0.0, last) or decision.speed < 0.0 for decision in right):
            yield "slower"


def _command(row: list[float]) -> dict[str, Said]:
    """Return what a command says: its numbers, and whether the robot drives and turns."""
    driving, turning = ("no" if abs(number) < ZERO else "yes" for number in (row[0], row[5]))
    return {"linear.x": row[0], "angular.z": row[5], "driving": driving, "turning": turning}


def _in_force(recording: Recording) -> Iterator[tuple[float, list[float], int]]:
    """Yield time [s] and fields of each command, and 1; of ticks without one: the last, and 0.

    A node that drives off and falls silent is wrong for as long as its last command counts.
    """
    twists = recording.twists()
    times = [0.0, *twists.t.tolist(), recording.duration_s]
    rows: list[list[float]] = [[], *twists.values.tolist()]
    for (t, end), row in zip(pairwise(times), rows, strict=True):
        if row:
            yield t, row, 1
        for tick in np.arange(t + SILENCE + recording.slack, end, PERIOD).tolist():
            yield tick, row, 0


def _reports(recording: Recording) -> list[Report]:
    """Return what was reported: a reason word, or else what stands in its place, and a level."""
    found: list[Report] = []
    for t, value in published(recording, DIAGNOSTICS_TOPIC, DIAGNOSTICS):
        if len(value.status) != 1:
            found.append((t, {"reason": f"{len(value.status)} statuses"}))
            continue
        (status,) = value.status
        word = re.match(r"\w+", status.message)
        text = word[0] if word and word[0] in LEVELS else status.message[:60]
        level = int(status.level)
        said = {"reason": text, "level": LEVEL_NAMES.get(level, f"{level}, which is none")}
        found.append((t, said))
    return found


def _forms(reports: list[Report]) -> Iterator[Case]:
    """Yield the occasions of each report: its form, and the level of the reason that it gives."""
    words = {"reason": frozenset(LEVELS)}
    for t, said in reports:
        yield Case(t, "a report", frozenset({"report"}), words, said)
        if level := LEVELS.get(str(said["reason"])):
            what, right = f"a report of “{said['reason']}”", {"level": frozenset({level})}
            yield Case(t, what, frozenset({"level", level}), right, said)


class _Sent:
    """What the node was sent, and when."""

    def __init__(self, recording: Recording) -> None:
        raw = (m for m in recording.delivered if m.topic == CMD_VEL_RAW_TOPIC)
        stops = (m for m in recording.delivered if m.topic == E_STOP_TOPIC)
        self._raw = [(m.time / 1e9, twist_from_cdr(m.data)) for m in raw]
        self._stops = [(m.time / 1e9, decode(m.data, BOOL).data) for m in stops]
        self._scans = [(scan.t, front_distances(scan)) for scan in recording.scans()]

    def by(self, arrived: float, now: float) -> Situation:
        """Return what had arrived by a time [s], with ages as they are now [s]."""
        _, pressed = _newest(self._stops, arrived)
        asked_at, asked = _newest(self._raw, arrived)
        seen_at, distances = _newest(self._scans, arrived)
        return Situation(bool(pressed), asked, now - asked_at, distances or (), now - seen_at)


def _newest(sent: Sequence[tuple[float, T]], t: float) -> tuple[float, T | None]:
    """Return the newest by t [s], and its time [s]."""
    i = bisect_right(sent, t, key=itemgetter(0))
    return sent[i - 1] if i else (-math.inf, None)
