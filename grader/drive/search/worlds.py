"""Worlds to search a node in, as hypothesis draws them: the simplest first, and shrunk to it.

Everything is drawn in whole steps (decimetres, 15°, 50 ms) for files that a person can read. What
the exercises ask only of nodes with the badge field-ready, other lidars, lost messages and drivers
that publish best effort, is in a world only if it is asked for.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from hypothesis import strategies as st
from hypothesis.strategies import DrawFn, SearchStrategy
from msgspec.structs import replace

from grader.checks.contract import Contract
from grader.course.exercises import Exercise
from grader.drive.search.fair import is_fair
from grader.exercises import driving_contract_of
from sim.scenario import (
    Faults,
    LidarSpec,
    OdometrySpec,
    Qos,
    RawCommands,
    RobotSpec,
    Scenario,
    ScriptEvent,
)
from sim.world import Box, Wall, World

MOST_THINGS = 3
THICK = 0.1  # [m] of a wall: one seen from its end is still seen
ROOM = Wall(points=((-3.0, -3.0), (4.0, -3.0), (4.0, 3.0), (-3.0, 3.0)), closed=True)
LIDARS = ("default", "lds02", "lds01", "wide")
Place = tuple[float, float, float]  # x [m], y [m], yaw [°]
SILENCE = 4.0  # [s] that a lidar falls silent
E_STOP = 2.0  # [s] that an emergency stop lasts
_NONE = st.just(0.0)
_LOSS = st.sampled_from((0.0, 0.1, 0.2))
_QOS = st.sampled_from((Qos(), Qos(sensors="sensor_data")))


@dataclass(frozen=True)
class Arena:
    """Where a node of an exercise is looked at, and by what it is judged."""

    worlds: SearchStrategy[Scenario]
    contract: Contract


def arena_of(exercise: Exercise, *, field: bool = False) -> Arena:
    """Return the worlds and the contract of an exercise.

    `field`: also what only nodes with the badge field-ready have to cope with.

    Raises
    ------
    InputError
        Its nodes do not drive.
    """
    contract = driving_contract_of(exercise)
    worlds = _goals(field) if contract.goals else _driving(contract, field).filter(is_fair)
    return Arena(worlds, contract)


def _dm(value: int) -> float:
    return value / 10


@st.composite
def _box(draw: DrawFn) -> Box:
    """Draw a box that is mostly in the robot's way, or beside it."""
    size = _dm(draw(st.integers(1, 6)))
    x, y = draw(st.integers(5, 20)), draw(st.integers(-12, 12))
    if draw(st.booleans()):  # as near to the way as it gets
        y = max(-3, min(3, y))
    turn = draw(st.sampled_from((0.0, 45.0, 15.0, 30.0)))
    return Box(center=(_dm(x), _dm(y)), size=(size, size), yaw_deg=turn)


@st.composite
def _wall(draw: DrawFn) -> Box:
    """Draw a wall: long and thin, at any angle."""
    length = _dm(draw(st.integers(5, 30)))
    x, y = draw(st.integers(8, 20)), draw(st.integers(-15, 15))
    turn = draw(st.sampled_from((90.0, 60.0, 120.0, 45.0, 135.0, 30.0, 150.0, 15.0, 165.0)))
    return Box(center=(_dm(x), _dm(y)), size=(length, THICK), yaw_deg=turn)


@st.composite
def _world(draw: DrawFn) -> World:
    things = draw(st.lists(st.one_of(_box(), _wall()), max_size=MOST_THINGS))
    return World(boxes=tuple(things), walls=(ROOM,) if draw(st.booleans()) else ())


@st.composite
def _lidar_faults(draw: DrawFn, field: bool) -> Faults:
    """Draw nothing wrong in most cases, else a little of it."""
    if not draw(st.booleans()):
        return Faults()
    begin = draw(st.integers(0, 5)) / 2  # [s]; 0: never
    return Faults(
        nan_speckle=draw(st.sampled_from((0.0, 0.02, 0.05))),
        scan_loss=draw(_LOSS if field else _NONE),
        scan_latency=draw(st.sampled_from((0.0, 0.05, 0.1))),
        range_noise=draw(st.sampled_from((0.0, 0.01))),
        blackout=((begin, begin + SILENCE),) if begin else (),
    )


@st.composite
def _driving(draw: DrawFn, contract: Contract, field: bool) -> Scenario:
    """Draw a world of things that stand, and a lidar."""
    return Scenario(
        title="",
        world=draw(_world()),
        duration=contract.search_for,
        node=draw(st.sampled_from(contract.nodes)),
        raw=draw(_raw(contract.search_for)) if contract.supervises else (),
        script=draw(_e_stops()) if contract.supervises else (),
        lidar=LidarSpec(profile=draw(st.sampled_from(LIDARS if field else LIDARS[:1]))),
        faults=draw(_lidar_faults(field)),
        qos=draw(_QOS) if field else Qos(),
        odometry=OdometrySpec(enabled=False),
    )


@st.composite
def _raw(draw: DrawFn, duration: float) -> tuple[RawCommands, ...]:
    """Draw what a model asks for: a turn on the spot, or none, then straight ahead."""
    turn = draw(st.sampled_from((0.0, 1.0, -1.0, 3.0, -3.0)))
    speeds = st.sampled_from((0.3, 0.2, 0.5, 1.0, float("nan")))
    first, then = draw(speeds), draw(speeds)
    begin, half, rate = 0.33, duration / 2 + 0.03, 10.0
    phases = [(0.0, turn, 1.03)] if turn else []
    phases += [(first, 0.0, half), (then, 0.0, duration)]
    streams: list[RawCommands] = []
    for speed, turning, end in phases:
        if streams and streams[-1].linear_x == speed and streams[-1].angular_z == turning:
            streams[-1] = replace(streams[-1], end=end)
        else:
            streams.append(
                RawCommands(begin=begin, end=end, linear_x=speed, angular_z=turning, rate=rate)
            )
        begin = end
    return tuple(streams)


@st.composite
def _e_stops(draw: DrawFn) -> tuple[ScriptEvent, ...]:
    at = draw(st.integers(0, 5))
    if not at:
        return ()
    return (ScriptEvent(at=float(at), e_stop=True), ScriptEvent(at=at + E_STOP, e_stop=False))


@st.composite
def _goals(draw: DrawFn, field: bool) -> Scenario:
    """Draw a start, and one goal or two, far enough from it and near enough to be reached."""
    half_metres = st.integers(-3, 3).map(lambda n: n / 2)
    yaw = draw(st.sampled_from((0.0, 90.0, -90.0, 180.0, 135.0, -135.0, 45.0, -45.0)))
    start = (draw(half_metres), draw(half_metres), yaw)
    goals = [(draw(half_metres), draw(half_metres), 0.0)]
    if draw(st.booleans()):
        goals.append((draw(half_metres), draw(half_metres), 0.0))
    script = tuple(
        ScriptEvent(at=0.55 + 3.0 * index, goal=goal) for index, goal in enumerate(goals)
    )
    lossy = draw(st.booleans())
    return Scenario(
        title="",
        world=World(description="An open floor."),
        duration=_time_for(start, goals, script[-1].at),
        robot=RobotSpec(start=start),
        script=script,
        lidar=LidarSpec(enabled=False),
        odometry=OdometrySpec(rate=draw(st.sampled_from((20.0, 100.0) if field else (20.0,)))),
        faults=Faults(
            odom_loss=draw(_LOSS) if lossy and field else 0.0,
            odom_latency=draw(st.sampled_from((0.0, 0.05, 0.1))) if lossy else 0.0,
        ),
        qos=draw(_QOS) if field else Qos(),
    )


def _time_for(start: Place, goals: Sequence[Place], last: float) -> float:
    """Return a duration in which even a slow turner arrives: 4 s for each metre, and 8 s [s]."""
    way = max(math.dist(place[:2], goals[-1][:2]) for place in (start, *goals))
    return round(last + 8.0 + 4.0 * way, 1)
