"""The contract of three_nodes: who is there, what they tell one another, and what the guard does.

nodes, drivers   the graph: which nodes there are, and which of them publish on /cmd_vel
distance         a scan: what the watcher tells of it
wish             a scan: what the driver wants, by the launch file's parameters or the defaults
speed            a scan: what the robot gets, by the launch file's parameters
fresh, old       a command of the guard alone, whose newest wish is fresh, or too old
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

from grader.checks.ahead import HAIR, front_distances
from grader.checks.case import Allowed, Case, exactly
from grader.checks.commands import answers, published
from grader.checks.contract import Contract, Limits
from grader.checks.wiring import OURS
from grader.recording import Recording
from sim.messages import CMD_VEL_RAW_TOPIC, FLOAT64, TWIST, twist_from_cdr

GUARD = "/shuttle/guard"
NODES = ("/shuttle/driver", GUARD, "/shuttle/watcher")
CRUISE, STOP, LIMIT = 0.4, 0.6, 0.25  # [m/s, m, m/s] by the launch file
OWN_CRUISE, OWN_STOP = 0.2, 0.5  # [m/s, m] the driver's defaults
ALONE = 0.3  # [m/s] max_speed of the guard where it runs alone
PATIENCE, UNSURE = 0.5, 0.06  # [s] a wish is old then; so near to that both are right
MOMENT = 0.001  # [s]
START_UP = 0.6  # [s] until all have found one another
Told = list[tuple[float, float]]  # when [s], and what
CONTRACT = Contract(limits=Limits(fastest=LIMIT), drives=False)


def cases(recording: Recording) -> list[Case]:
    """Return the occasions of a scenario: of the guard alone, or of all three nodes."""
    alone = any(program.file == "guard.py" for program in recording.scenario.program)
    if alone:
        sent = [m for m in recording.delivered if m.topic == CMD_VEL_RAW_TOPIC]
        asked = [(m.time / 1e9, twist_from_cdr(m.data)[0]) for m in sent]
        return list(_guarded(recording, asked, ALONE))
    told = [(t, m.data) for t, m in published(recording, "/shuttle/distance", FLOAT64)]
    wishes = published(recording, "/shuttle/cmd_vel_raw", TWIST)
    wanted = [(t, message.linear.x) for t, message in wishes]
    guarded = _guarded(recording, wanted, LIMIT)
    return [*_graph(recording), *_passed_on(recording, told, wanted), *guarded]


def _graph(recording: Recording) -> Iterator[Case]:
    ends = [end for end in recording.endpoints if not end.node.startswith(OURS)]
    drivers = [end for end in ends if (end.kind, end.topic) == ("publisher", "/cmd_vel")]
    for name, found, right in (("nodes", ends, NODES), ("drivers", drivers, (GUARD,))):
        said = ", ".join(sorted({end.node for end in found})) or "none"
        what = {"nodes": "the graph", "drivers": "who publishes on /cmd_vel"}[name]
        yield Case(
            0.0, what, frozenset({name}), {name: frozenset({", ".join(right)})}, {name: said}
        )


def _passed_on(recording: Recording, told: Told, wanted: Told) -> Iterator[Case]:
    given = answers(recording)
    ends = [*(answer.scan.t for answer in given[1:]), math.inf]
    for answer, end in zip(given, ends, strict=False):
        begin, seen = answer.scan.t, front_distances(answer.scan)
        if begin < START_UP:
            continue
        blind = None in seen
        near = [(d, d) if math.isinf(d) else (d - HAIR, d + HAIR) for d in seen if d is not None]
        yield _case(
            answer.what, "distance", begin, end, told, {} if blind else {"data": tuple(near)}
        )
        if blind:
            continue
        hair = {edge for pair in near for edge in pair}
        right = [CRUISE if d >= STOP else 0.0 for d in hair]
        other = [OWN_CRUISE if d >= OWN_STOP else 0.0 for d in hair]
        allowed = {"linear.x": exactly(*right, *other)}
        yield _case(answer.what, "wish", begin, end, wanted, allowed)
        yield _case(answer.what, "set", begin, end, wanted, {"linear.x": exactly(*right)})
        limited: dict[str, Allowed] = {"linear.x": exactly(*(min(x, LIMIT) for x in right))}
        yield Case(begin, answer.what, frozenset({"speed"}), limited, answer.said("linear.x"))


def _case(
    what: str,
    tag: str,
    begin: float,
    end: float,
    told: Told,
    allowed: Mapping[str, Allowed],
) -> Case:
    """Return the occasion of a scan, and what was told between it and the next."""
    said = [value for t, value in told if begin <= t < end]
    name = next(iter(allowed), "data")
    return Case(begin, what, frozenset({tag}), allowed, {name: said[-1]} if said else {}, len(said))


def _guarded(recording: Recording, wishes: Told, most: float) -> Iterator[Case]:
    twists = recording.twists()
    for t, said in zip(twists.t.tolist(), twists.linear_x.tolist(), strict=True):
        heard = [wish for wish in wishes if wish[0] <= t][-2:] or [(-math.inf, 0.0)]
        if t - heard[-1][0] > MOMENT:
            heard = heard[-1:]  # of wishes at this very moment the one before is right, too
        age, wish = t - heard[-1][0], heard[-1][1]
        safe = [min(max(w, 0.0), most) if math.isfinite(w) else 0.0 for _, w in heard]
        speeds = safe * (age < PATIENCE + UNSURE) + [0.0] * (age > PATIENCE - UNSURE)
        what = f"a wish of {wish:.2f} m/s, {age:.2f} s old" if age < math.inf else "no wish yet"
        tag = "old" if age > PATIENCE else "fresh"
        allowed: dict[str, Allowed] = {"linear.x": exactly(*speeds)}
        yield Case(t, what, frozenset({tag}), allowed, {"linear.x": said})
