"""The contract of three_nodes: who is there, what they tell one another, and what the guard does.

nodes, drivers   the graph: which nodes there are, and which of them publish on /cmd_vel
given            a parameter, as the launch file gives it
distance         a scan: what the watcher tells of it
wish             a distance, or none: what the driver wants
speed            a scan: what the robot gets, by the launch file's parameters
fresh, old       a command of the guard, whose newest wish is fresh, or too old
"""

from __future__ import annotations

import json
import math
from collections.abc import Collection, Iterator, Mapping
from pathlib import PurePath

from grader.checks.ahead import HAIR, front_distances
from grader.checks.case import Allowed, Case, Said, exactly
from grader.checks.commands import answers, published
from grader.checks.contract import Contract, Limits
from grader.recording import Recording, Scan
from sim.messages import CMD_VEL_RAW_TOPIC, FLOAT64, TWIST, twist_from_cdr

DRIVER, GUARD, WATCHER = "/shuttle/driver", "/shuttle/guard", "/shuttle/watcher"
NODES = {DRIVER: "driver.py", GUARD: "guard.py", WATCHER: "watcher.py"}  # and their programs
CRUISE, STOP, LIMIT = 0.4, 0.6, 0.25  # [m/s, m, m/s] by the launch file
GIVEN = {"cruise_speed": CRUISE, "stop_distance": STOP, "max_speed": LIMIT}
CRUISE_ALONE, STOP_ALONE, LIMIT_ALONE = 0.45, 0.75, 0.3  # of a program that runs alone
PATIENCE, UNSURE = 0.5, 0.06  # [s] a wish is old then; so near to that both are right
MOMENT = 0.001  # [s]
START_UP = 0.6  # [s] until all have found one another
Told = list[tuple[float, float]]  # when [s], and what
CONTRACT = Contract(limits=Limits(fastest=LIMIT), drives=False)


def cases(recording: Recording) -> list[Case]:
    """Return the occasions of a scenario: of the launch file, of a program, or of all together."""
    if recording.scenario.node.stand_in:
        return [*_graph(recording), *_given(recording)]
    alone = {program.file for program in recording.scenario.program}
    if "guard.py" in alone:
        sent = [m for m in recording.delivered if m.topic == CMD_VEL_RAW_TOPIC]
        asked = [(m.time / 1e9, twist_from_cdr(m.data)[0]) for m in sent]
        return list(_guarded(recording, asked, LIMIT_ALONE))
    told = [(t, m.data) for t, m in published(recording, "/shuttle/distance", FLOAT64)]
    wishes = published(recording, "/shuttle/cmd_vel_raw", TWIST)
    wanted = [(t, message.linear.x) for t, message in wishes]
    if "driver.py" in alone:
        return list(_wishes(recording, told, wanted))
    if "watcher.py" in alone:
        return list(_distances(recording, told))
    running = {PurePath(end.process).name for end in recording.ends}
    unseen = {GUARD, *(name for name, file in NODES.items() if file not in running)}
    others = [*_graph(recording, unseen), *_distances(recording, told), *_speeds(recording)]
    return [*others, *_guarded(recording, wanted, LIMIT)]


def given(recording: Recording) -> dict[str, Said]:
    """Return the parameters that the launch file gives to the course's own programs."""
    found: dict[str, Said] = {}
    for line in recording.log:
        if line.level == "stdout" and line.text.startswith("{"):
            found |= json.loads(line.text)
    return found


def _given(recording: Recording) -> Iterator[Case]:
    said = given(recording)
    for name, value in GIVEN.items():
        mine = {name: said[name]} if name in said else {}
        yield Case(0.0, name, frozenset({"given"}), {name: exactly(value)}, mine)


def _graph(recording: Recording, unseen: Collection[str] = ()) -> Iterator[Case]:
    """Yield who is there, and who drives; of `unseen` nodes that don't, other checks tell."""
    drivers = [e for e in recording.ends if (e.kind, e.topic) == ("publisher", "/cmd_vel")]
    for tag, wanted, ends in (("nodes", NODES, recording.ends), ("drivers", (GUARD,), drivers)):
        seen = [_named(node, by) for node, by in {(end.node, end.process) for end in ends}]
        found = sorted([*seen, *(node for node in unseen if node in wanted and node not in seen)])
        what = {"nodes": "the graph", "drivers": "who publishes on /cmd_vel"}[tag]
        allowed: dict[str, Allowed] = {tag: frozenset({", ".join(sorted(wanted))})}
        yield Case(0.0, what, frozenset({tag}), allowed, {tag: ", ".join(found) or "none"})


def _named(node: str, process: str) -> str:
    """Return a node; where another program plays it, that program, too."""
    return node if NODES.get(node) == PurePath(process).name else f"{node} of {process}"


def _distances(recording: Recording, told: Told) -> Iterator[Case]:
    for scan, what, end in _scans(recording):
        seen = front_distances(scan)
        near = [(d, d) if math.isinf(d) else (d - HAIR, d + HAIR) for d in seen if d is not None]
        allowed: dict[str, Allowed] = {} if None in seen else {"data": tuple(set(near))}
        yield _case(recording, what, "distance", scan.t, end, told, allowed)


def _wishes(recording: Recording, told: Told, wanted: Told) -> Iterator[Case]:
    for scan, what, end in _scans(recording):
        heard = [CRUISE_ALONE if d >= STOP_ALONE else 0.0 for t, d in told if scan.t <= t < end]
        allowed: dict[str, Allowed] = {"linear.x": exactly(heard[-1])} if heard else {}
        yield _case(recording, what, "wish", scan.t, end, wanted, allowed)


def _speeds(recording: Recording) -> Iterator[Case]:
    for answer in answers(recording):
        seen = front_distances(answer.scan)
        if answer.scan.t >= START_UP and None not in seen:
            hair = [d + by for d in seen if d is not None for by in (-HAIR, HAIR)]
            speeds = exactly(*{min(CRUISE, LIMIT) if d >= STOP else 0.0 for d in hair})
            allowed: dict[str, Allowed] = {"linear.x": speeds}
            said = answer.said("linear.x")
            yield Case(answer.scan.t, answer.what, frozenset({"speed"}), allowed, said)


def _scans(recording: Recording) -> Iterator[tuple[Scan, str, float]]:
    """Yield each scan, in words, too, and when the next one comes [s]."""
    found = answers(recording)
    ends = [*(answer.scan.t for answer in found[1:]), math.inf]
    for answer, end in zip(found, ends, strict=False):
        if answer.scan.t >= START_UP:
            yield answer.scan, answer.what, end


def _case(
    recording: Recording,
    what: str,
    tag: str,
    begin: float,
    end: float,
    told: Told,
    allowed: Mapping[str, Allowed],
) -> Case:
    """Return the occasion of a scan: what was told between it and the next, once."""
    values = [value for t, value in told if begin <= t < end]
    said: dict[str, Said] = {name: values[-1] for name in allowed if values}
    if allowed and values and recording.live is None:
        allowed = {**allowed, "messages": exactly(1.0)}
        said["messages"] = float(len(values))
    return Case(begin, what, frozenset({tag}), allowed, said, len(values))


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
        allowed: dict[str, Allowed] = {"linear.x": exactly(*set(speeds))}
        yield Case(t, what, frozenset({tag}), allowed, {"linear.x": said})
