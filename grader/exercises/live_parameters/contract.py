"""The contract of live_parameters: the parameters, and the speeds that they ask for.

scan        a scan: the speed that it and the parameters of that moment ask for
describe    what the node says of a parameter: its type, range and meaning
accept      somebody sets what may be set
refuse      somebody sets what may not: the answer is no, with a reason
set         an order by `set_parameters`, which decides on each value by itself
atomically  an order by `set_parameters_atomically`: all or none
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from itertools import product

from grader.checks.ahead import HAIR, front_distances
from grader.checks.case import Allowed, Case, Interval, Runs, answered, exactly
from grader.checks.commands import answers
from grader.checks.contract import RACE, Contract, free_from
from grader.checks.parameters import Order, orders
from grader.checks.verbs import TOLERANCE, require_allowed
from grader.checks.wiring import require_alive
from grader.recording import Recording, Scan
from sim.messages import CMD_VEL_TOPIC

Settings = dict[str, str | bool | int | float]
RANGES = {"cruise_speed": (0.0, 0.5), "stop_distance": (0.3, 2.0), "slow_distance": (0.3, 4.0)}
DEFAULTS: Settings = {"cruise_speed": 0.3, "stop_distance": 0.5, "slow_distance": 1.0}
DOUBLE = 3  # of rcl_interfaces/msg/ParameterType
CONTRACT = Contract(free=free_from(0.55), race=RACE)
SET = "/live_parameters_agent/set_parameters"
UNSAFE = (
    "Is every value of the command line checked, its type, its range, and whether the two distances"
    " fit? The node may end, or go on with values that may be set."
)


def may_be(settings: Settings) -> bool:
    """Return whether these values may be set, together."""
    values = [settings[name] for name in RANGES]
    if not all(isinstance(value, float) for value in values):
        return False
    inside = all(low <= float(settings[name]) <= high for name, (low, high) in RANGES.items())
    return inside and float(settings["stop_distance"]) <= float(settings["slow_distance"])


def cases(recording: Recording) -> list[Case]:
    """Return the occasions of orders, and of scans, in order.

    After a start with values that may not be set it may go on with any that may: these are the
    values by which most of its answers are right.
    """
    ways = (list(_cases(recording, start)) for start in _starts(recording.scenario.node.parameters))
    wrong = (([c.at for c in way if c.wrong(TOLERANCE)], way) for way in ways)
    _, best = max(wrong, key=lambda each: min(each[0], default=math.inf))
    return sorted(best, key=lambda case: case.at)


def by_answer(recording: Recording) -> list[Case]:
    """Return the occasions without the reasons, for which `refused` and `pairs` ask."""
    return [
        replace(case, allowed={n: allowed for n, allowed in case.allowed.items() if n != "reason"})
        for case in cases(recording)
    ]


def _starts(given: Settings) -> Iterator[Settings]:
    """Yield the values with which a node may begin to drive that was started with these."""
    if may_be(DEFAULTS | given):
        yield DEFAULTS | given
        return
    near = [v for n, v in (*DEFAULTS.items(), *given.items()) if n != "cruise_speed"]
    for cruise, *distances in product(
        (DEFAULTS["cruise_speed"], given.get("cruise_speed", 0.0), *RANGES["cruise_speed"]),
        *((DEFAULTS[n], *near, *RANGES[n]) for n in ("stop_distance", "slow_distance")),
    ):
        settings = dict(zip(RANGES, (cruise, *distances), strict=True))
        if may_be(settings):
            yield settings


def _cases(recording: Recording, settings: Settings) -> Iterator[Case]:
    changes = [(0.0, settings)]
    for order in orders(recording):
        wanted: Settings = settings | dict(order.wanted)
        if not order.wanted:
            yield from _described(order)
            continue
        yield _asked(order, may_be(wanted))
        if may_be(wanted):
            changes.append((order.at, settings := wanted))
    for answer in answers(recording):
        now = [each for at, each in changes if at <= answer.scan.t][-1]
        spelled = ", ".join(f"{name} {now[name]}" for name in RANGES)
        what = f"{answer.what}, with {spelled}"
        yield answered(answer, {"linear.x": right_speeds(answer.scan, now)}, "scan", what=what)


def right_speeds(scan: Scan, settings: Settings) -> tuple[Interval, ...]:
    """Return what is right [m/s] for a scan, by settings that may be made."""
    seen = [d for distance in front_distances(scan) for d in _about(distance, settings)]
    cruise, stop, slow = (float(settings[name]) for name in RANGES)
    return exactly(*(0.0 if d < stop else cruise / 2 if d < slow else cruise for d in seen))


def _about(distance: float | None, settings: Settings) -> tuple[float, ...]:
    """Return a distance [m], on both sides of a threshold that it is a hair away from."""
    if distance is None:
        return (0.0,)
    edges = [float(settings[name]) for name in RANGES if name != "cruise_speed"]
    near = any(0.0 < abs(distance - edge) < HAIR for edge in edges)
    return (distance - HAIR, distance + HAIR) if near else (distance,)


def _asked(order: Order, right: bool) -> Case:
    allowed = {"answer": frozenset({"yes" if right else "no"})}
    answer, said = order.answer, dict[str, str]()
    if not right:
        allowed["reason"] = frozenset({"given"})
    if answer is not None:
        said = {"answer": "yes" if answer.accepted else "no"}
        said["reason"] = "given" if answer.reason.strip() else "none"
    tags = {"accept" if right else "refuse", "atomically" if len(order.wanted) > 1 else "set"}
    return Case(order.at, order.text, frozenset(tags), allowed, said, len(said))


def _described(order: Order) -> Iterator[Case]:
    """Yield the occasion of each parameter: it is a double with a range and a meaning."""
    there = {each.name: each for each in order.answer.described} if order.answer else {}
    for name, (least, greatest) in RANGES.items():
        allowed: dict[str, Allowed] = {"type": frozenset({"double"}), "from_value": exactly(least)}
        allowed |= {"to_value": exactly(greatest), "description": frozenset({"given"})}
        said: dict[str, float | str] = {}
        if name in there:
            about = there[name]
            said = {"type": "double" if about.type == DOUBLE else "another"}
            said |= dict(zip(("from_value", "to_value"), about.limits, strict=False))
            said["description"] = "given" if about.description.strip() else "none"
        yield Case(order.at, name, frozenset({"describe"}), allowed, said, len(said))


def starts_safely(runs: Runs) -> None:
    """Fail unless a node that was started with wrong values ends unheard, or drives by others."""
    for recording in runs:
        if not recording.outcome.completed and not len(recording.twists().t):
            continue
        require_alive(recording)
        given = ", ".join(f"{n}:={v}" for n, v in recording.scenario.node.parameters.items())
        for _, case in runs.of([recording]).cases():
            at = case.what.split(", with ")[0]
            what = f"started with {given} it goes on with what may not be set, seen at {at}"
            topic = CMD_VEL_TOPIC if "scan" in case.tags else SET
            require_allowed(recording, replace(case, what=what), UNSAFE, topic=topic)
