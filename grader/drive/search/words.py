"""A world and what went wrong in it, in a student's words."""

import math

import numpy as np

from grader.drive.mishaps import LOST, STANDS, TOUCHES, Mishap
from grader.recording import Recording
from sim.clearance import clearance
from sim.placement import build_layout
from sim.scenario import Scenario
from sim.world import Box, World

AHEAD = 5.0  # [°] within which a thing is straight ahead
ASIDE = 10.0  # [°] beyond which it is worth saying which beams see it
LOOK_BACK = 1.0  # [s] before a touch
LONG = 3.0  # times as long as wide: a wall


def title(scenario: Scenario) -> str:
    """Return a short title of a world, for its file."""
    return (" and ".join(_things(scenario)) or "an empty world").capitalize()


def sentence(recording: Recording, mishap: Mishap) -> str:
    """Return the sentence that a student reads: the world, its faults, and events with times."""
    scenario = recording.scenario
    ends = {STANDS: f", from {mishap.at:.1f} s on", LOST: f" in {recording.duration_s:.0f} s"}
    when = ends.get(mishap.kind, f" at {mishap.at:.1f} s")
    things = [_touched(recording, mishap.at)] if mishap.kind == TOUCHES else _things(scenario)
    where = ", ".join(" and ".join(said) for said in (things, _faults(scenario)) if said)
    text = f"{where or 'in an empty world'}: {mishap.text}{when}."
    return text[0].upper() + text[1:]


def _things(scenario: Scenario) -> list[str]:
    """Name the things in a world, or its goals."""
    goals = [event.goal for event in scenario.script if event.goal is not None]
    if goals:
        return [f"a goal {'; then one '.join(_place(scenario, goal[:2]) for goal in goals)}"]
    named = [_named(scenario, box) for box in scenario.world.boxes]
    return named + (["a room"] if scenario.world.walls else [])


def _named(scenario: Scenario, box: Box) -> str:
    """Return "a box of 0.3 m at 1.1 m, 40° to the left"."""
    long, short = max(box.size), min(box.size)
    what = f"a wall of {long:g} m" if long > LONG * short else f"a box of {long:g} m"
    return f"{what} {_place(scenario, box.center)}"


def _place(scenario: Scenario, point: tuple[float, float]) -> str:
    """Return distance and bearing of a point from the robot's start."""
    x, y, yaw = scenario.robot.start
    dx, dy = point[0] - x, point[1] - y
    bearing = (math.degrees(math.atan2(dy, dx)) - yaw + 180.0) % 360.0 - 180.0
    where = f"{abs(bearing):.0f}° to the {'left' if bearing > 0 else 'right'}"
    if abs(bearing) < AHEAD:
        where = "straight ahead"
    elif abs(bearing) > 180.0 - AHEAD:
        where = "straight behind"
    return f"at {math.hypot(dx, dy):.1f} m, {where}"


def _touched(recording: Recording, at: float) -> str:
    """Name the thing that the robot touches, and count the others."""
    world, pose = recording.scenario.world, _pose(recording, at)
    gaps = [_gap(World(boxes=(box,)), pose) for box in world.boxes]
    if min(gaps, default=math.inf) > _gap(World(walls=world.walls), pose):
        return "the wall of a room"
    box = world.boxes[int(np.argmin(gaps))]
    others = f" (and {len(gaps) - 1} more)" if len(gaps) > 1 else ""
    return f"{_named(recording.scenario, box)}{_beams(recording, at, box)}{others}"


def _gap(world: World, pose: tuple[float, float, float]) -> float:
    return float(clearance(build_layout(world), np.zeros(1), np.array([pose[:2]]), 0.0)[0])


def _beams(recording: Recording, at: float, box: Box) -> str:
    """Say which beams see a box in the last second before it is touched, if none ahead does."""
    (polygon,) = build_layout(World(boxes=(box,))).solids
    edge = np.linspace(polygon, np.roll(polygon, -1, axis=0), 20).reshape(-1, 2)
    seen = []  # [°]
    for t in np.arange(max(0.0, at - LOOK_BACK), at + 1e-9, 0.1):
        x, y, yaw = _pose(recording, float(t))
        angles = np.degrees(np.arctan2(edge[:, 1] - y, edge[:, 0] - x) - yaw)
        seen.append((angles + 180.0) % 360.0 - 180.0)
    least = np.abs(seen).min()
    if least < ASIDE:
        return ""
    where = "left" if np.sign(seen).sum() > 0 else "right"
    return f", seen only by beams beyond {math.floor(least)}° to the {where} in the last second"


def _pose(recording: Recording, at: float) -> tuple[float, float, float]:
    truth = recording.truth
    i = int(np.searchsorted(truth.t, round(at * 1e9), side="right")) - 1
    return float(truth.x[i]), float(truth.y[i]), float(truth.yaw[i])


def _faults(scenario: Scenario) -> list[str]:
    """Name a world's faults, and its sensors if they are unusual."""
    faults, lidar, odometry = scenario.faults, scenario.lidar, scenario.odometry
    model = scenario.node.parameters.get("model_path")
    late = faults.scan_latency or faults.odom_latency
    speeds = dict.fromkeys(f"{stream.linear_x:g}" for stream in scenario.raw if stream.linear_x)
    said: dict[str, object] = {
        f"with the lidar {lidar.profile}": lidar.enabled and lidar.profile != "default",
        f"with odometry at {odometry.rate:.0f} Hz": odometry.enabled and odometry.rate != 20.0,
        f"with the model {model}": model,
        "with sensors that publish best effort": scenario.qos.sensors != "reliable",
        f"with {faults.scan_loss:.0%} of the scans lost": faults.scan_loss,
        f"with {faults.odom_loss:.0%} of the odometry lost": faults.odom_loss,
        f"with {faults.nan_speckle:.0%} of the readings NaN": faults.nan_speckle,
        f"with sensors {late * 1000:.0f} ms late": late,
        f"with noise of {faults.range_noise * 100:.0f} cm": faults.range_noise,
        f"with a model that asks for {' and '.join(speeds)} m/s": speeds,
    }
    said |= {f"without scans from {begin:g} to {end:g} s": True for begin, end in faults.blackout}
    stops = [event.at for event in scenario.script if event.e_stop]
    said |= {f"with an emergency stop at {at:g} s": True for at in stops}
    return [words for words, true in said.items() if true]
