"""A world and what went wrong in it, in a student's words."""

from __future__ import annotations

import math

import numpy as np

from grader.drive.mishaps import LOST, STANDS, TOUCHES, Mishap
from grader.recording import Recording
from sim.clearance import clearance
from sim.layout import Layout
from sim.placement import build_layout
from sim.scenario import Scenario
from sim.world import Box, World

AHEAD = 5.0  # [°] within which a thing is straight ahead
ASIDE = 10.0  # [°] beyond which it is worth saying which beams see it
LOOK_BACK = 1.0  # [s] before a touch
LONG = 3.0  # times as long as wide: a wall


def sentence(recording: Recording, mishap: Mishap) -> str:
    """Return what a student reads: the world, its faults, and what happened when."""
    scenario = recording.scenario
    things = _things(recording, mishap)
    faults = _faults(scenario)
    where = f"{things}, {' and '.join(faults)}" if things and faults else things
    where = where or " and ".join(faults) or "in an empty world"
    text = f"{where}: {mishap.text}{_when(recording, mishap)}."
    return text[0].upper() + text[1:]


def _when(recording: Recording, mishap: Mishap) -> str:
    if mishap.kind == STANDS:
        return f", from {mishap.at:.1f} s on"
    if mishap.kind == LOST:
        return f" in {recording.duration_s:.0f} s"
    return f" at {mishap.at:.1f} s"


def title(scenario: Scenario) -> str:
    """Return a short title of a world, for its file."""
    boxes = scenario.world.boxes
    goals = [event.goal for event in scenario.script if event.goal is not None]
    if goals:
        return f"A goal {_place(_seen_from(scenario, goals[-1][:2]))}"
    if not boxes:
        return "A room" if scenario.world.walls else "An empty world"
    return "; ".join(_named(scenario, box) for box in boxes).capitalize()


def _things(recording: Recording, mishap: Mishap) -> str:
    scenario = recording.scenario
    goals = [event.goal for event in scenario.script if event.goal is not None]
    if goals:
        places = [_place(_seen_from(scenario, goal[:2])) for goal in goals]
        return f"a goal {'; then one '.join(places)}"
    boxes = list(scenario.world.boxes)
    if mishap.kind == TOUCHES and boxes:
        touched = _touched(recording, mishap.at)
        if touched is None:
            return "the wall of a room"
        box = boxes.pop(touched)
        beams = _beams(recording, mishap.at, box)
        return f"{_named(scenario, box)}{beams}{_others(len(boxes))}"
    if mishap.kind == TOUCHES:
        return "the wall of a room"
    named = [_named(scenario, box) for box in boxes]
    return " and ".join(named + (["a room"] if scenario.world.walls else []))


def _others(count: int) -> str:
    return f" (and {count} more)" if count else ""


def _named(scenario: Scenario, box: Box) -> str:
    """Return "a box of 0.3 m at 1.1 m, 40° to the left"."""
    long, short = max(box.size), min(box.size)
    what = f"a wall of {long:g} m" if long > LONG * short else f"a box of {long:g} m"
    return f"{what} {_place(_seen_from(scenario, box.center))}"


def _seen_from(scenario: Scenario, point: tuple[float, float]) -> tuple[float, float]:
    """Return distance [m] and bearing [°] of a point from the robot's start."""
    x, y, yaw = scenario.robot.start
    dx, dy = point[0] - x, point[1] - y
    bearing = math.degrees(math.atan2(dy, dx)) - yaw
    return math.hypot(dx, dy), (bearing + 180.0) % 360.0 - 180.0


def _place(seen: tuple[float, float]) -> str:
    distance, bearing = seen
    where = f"{abs(bearing):.0f}° to the {'left' if bearing > 0 else 'right'}"
    if abs(bearing) < AHEAD:
        where = "straight ahead"
    elif abs(bearing) > 180.0 - AHEAD:
        where = "straight behind"
    return f"at {distance:.1f} m, {where}"


def _touched(recording: Recording, at: float) -> int | None:
    """Return which box the robot touches; None: a wall of the room."""
    pose = _pose(recording, at)[:2]
    boxes = recording.scenario.world.boxes
    gaps = [_gap(build_layout(World(boxes=(box,))), pose) for box in boxes]
    room = _gap(build_layout(World(walls=recording.scenario.world.walls)), pose)
    nearest = int(np.argmin(gaps))
    return nearest if gaps[nearest] <= room else None


def _gap(layout: Layout, point: tuple[float, float]) -> float:
    return float(clearance(layout, np.zeros(1), np.array([point]), 0.0)[0])


def _beams(recording: Recording, at: float, box: Box) -> str:
    """Say which beams see a box in the last second before it is touched, if none ahead does."""
    layout = build_layout(World(boxes=(box,)))
    (polygon,) = layout.solids
    least, most = 180.0, 0.0
    side = 0.0
    for t in np.arange(max(0.0, at - LOOK_BACK), at + 1e-9, 0.1):
        x, y, yaw = _pose(recording, float(t))
        edge = np.linspace(polygon, np.roll(polygon, -1, axis=0), 20).reshape(-1, 2)
        angles = np.degrees(np.arctan2(edge[:, 1] - y, edge[:, 0] - x) - yaw)
        angles = (angles + 180.0) % 360.0 - 180.0
        least, most = min(least, np.abs(angles).min()), max(most, np.abs(angles).max())
        side += float(np.sign(angles).sum())
    if least < ASIDE:
        return ""
    where = "left" if side > 0 else "right"
    return f", seen only by beams beyond {math.floor(least)}° to the {where} in the last second"


def _pose(recording: Recording, at: float) -> tuple[float, float, float]:
    truth = recording.truth
    i = int(np.searchsorted(truth.t, round(at * 1e9), side="right")) - 1
    return float(truth.x[i]), float(truth.y[i]), float(truth.yaw[i])


def _faults(scenario: Scenario) -> list[str]:
    """Return what goes wrong in a world, and which sensors it has if not the usual ones."""
    faults, found = scenario.faults, []
    if scenario.lidar.enabled and scenario.lidar.profile != "default":
        found.append(f"with the lidar {scenario.lidar.profile}")
    if scenario.odometry.enabled and scenario.odometry.rate != 20.0:
        found.append(f"with odometry at {scenario.odometry.rate:.0f} Hz")
    if model := scenario.node.parameters.get("model_path"):
        found.append(f"with the model {model}")
    if scenario.qos.sensors != "reliable":
        found.append("with sensors that publish best effort")
    for value, what in (
        (faults.scan_loss, "of the scans lost"),
        (faults.odom_loss, "of the odometry lost"),
        (faults.nan_speckle, "of the readings NaN"),
    ):
        if value:
            found.append(f"with {value:.0%} {what}")
    if late := faults.scan_latency or faults.odom_latency:
        found.append(f"with sensors {late * 1000:.0f} ms late")
    if faults.range_noise:
        found.append(f"with noise of {faults.range_noise * 100:.0f} cm")
    for begin, end in faults.blackout:
        found.append(f"without scans from {begin:g} to {end:g} s")
    found += [f"with {said}" for said in _asked(scenario)]
    return found


def _asked(scenario: Scenario) -> list[str]:
    speeds = dict.fromkeys(f"{stream.linear_x:g}" for stream in scenario.raw if stream.linear_x)
    found = [f"a model that asks for {' and '.join(speeds)} m/s"] if speeds else []
    stops = [event.at for event in scenario.script if event.e_stop]
    return found + [f"an emergency stop at {at:g} s" for at in stops]
