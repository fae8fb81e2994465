"""The contract of live_parameters: the parameters, and the speeds that they ask for.

scan        a scan: the speed that it and the parameters of that moment ask for
describe    what the node says of a parameter: its type, range and meaning
accept      somebody sets what may be set
refuse      somebody sets what may not: the answer is no, with a reason
"""

from __future__ import annotations

from collections.abc import Iterator

from grader.checks.ahead import HAIR, front_distances
from grader.checks.case import Allowed, Case, Interval, Runs, answered, exactly
from grader.checks.commands import answers
from grader.checks.contract import Contract, free_from
from grader.checks.parameters import Order, orders
from grader.checks.verbs import follows
from grader.recording import Recording, Scan

Settings = dict[str, float | str]
RANGES = {"cruise_speed": (0.0, 0.5), "stop_distance": (0.3, 2.0), "slow_distance": (0.3, 4.0)}
DEFAULTS: Settings = {"cruise_speed": 0.3, "stop_distance": 0.5, "slow_distance": 1.0}
NEAREST = 0.3  # [m] nearer than this it stands, whatever the parameters say
DOUBLE = 3  # of rcl_interfaces/msg/ParameterType
FREE = free_from(0.55)
CONTRACT = Contract(
    free=FREE,
)
UNSAFE = "Is every value of the command line checked, and the command kept within its limits?"


def may_be(settings: Settings) -> bool:
    """Return whether these values may be set, together."""
    values = [settings[name] for name in RANGES]
    if any(isinstance(value, str) for value in values):
        return False
    inside = all(low <= float(settings[name]) <= high for name, (low, high) in RANGES.items())
    return inside and float(settings["stop_distance"]) <= float(settings["slow_distance"])


def cases(recording: Recording) -> list[Case]:
    """Return the occasions of orders, and of scans."""
    return list(_cases(recording))


def _cases(recording: Recording) -> Iterator[Case]:
    settings = DEFAULTS | recording.scenario.node.parameters
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
    """Return what is right [m/s] for a scan; of settings that nobody may make, whatever is safe."""
    seen = [d for distance in front_distances(scan) for d in _about(distance, settings)]
    if not may_be(settings):
        return ((0.0, 0.0 if min(seen) < NEAREST else CONTRACT.limits.fastest),)
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
    tag = "accept" if right else "refuse"
    return Case(order.at, order.text, frozenset({tag}), allowed, said, len(said))


def _described(order: Order) -> Iterator[Case]:
    """Yield the occasion of each parameter: it is a double with a range and a meaning."""
    there = {each.name: each for each in order.answer.described} if order.answer else {}
    for name, (least, greatest) in RANGES.items():
        allowed: dict[str, Allowed] = {
            "type": frozenset({"double"}),
            "least": exactly(least),
            "greatest": exactly(greatest),
            "description": frozenset({"given"}),
        }
        said: dict[str, float | str] = {}
        if name in there:
            about = there[name]
            said = {"type": "double" if about.type == DOUBLE else "another"}
            said |= dict(zip(("least", "greatest"), about.limits, strict=False))
            said["description"] = "given" if about.description.strip() else "none"
        yield Case(order.at, name, frozenset({"describe"}), allowed, said, len(said))


def starts_safely(runs: Runs) -> None:
    """Fail unless a node that was started with wrong values ends unheard, or drives safely."""
    for recording in runs:
        if recording.outcome.completed or len(recording.twists().t):
            follows(runs.of([recording]), "scan", help=UNSAFE)
