"""The worlds that a node is searched in.

A world is a *plan*: whole numbers, each of which chooses one of some options, the simplest first.
So any numbers make a world, zeros make the simplest, and a lower number makes a simpler one. Places
are in whole decimetres, for files that a person can read. What exercises ask only of nodes with the
badge field-ready (other lidars, lost messages, drivers that publish best effort) is in a world only
if it is asked for.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from random import Random
from typing import TypeVar

from grader.checks.contract import Contract
from grader.course.exercises import Exercise
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
ROOM = Wall(points=((-3.0, -3.0), (4.0, -3.0), (4.0, 3.0), (-3.0, 3.0)), closed=True)
LIDARS = ("default", "lds02", "lds01", "wide")
QOS = (Qos(), Qos(sensors="sensor_data"))
MAYBE = (False, True)
LOSS, LATE = (0.0, 0.1, 0.2), (0.0, 0.05, 0.1)  # a share, [s]
SPEEDS = (0.3, 0.2, 0.5, 1.0, math.nan)  # [m/s] that a model asks for
SILENCE = 4.0  # [s] that a lidar falls silent
E_STOP = 2.0  # [s] that an emergency stop lasts
THICK = 0.1  # [m] of a wall: one seen from its end is still seen
TURNS = (90.0, 60.0, 120.0, 45.0, 135.0, 30.0, 150.0, 15.0, 165.0)  # [°] of a wall
# Sizes and how far to a side [dm], and turns [°]
BOX = (range(1, 7), 12, (0.0, 45.0, 15.0, 30.0))
WALL = (range(5, 31), 15, TURNS)

Plan = tuple[int, ...]
T = TypeVar("T")


class Draw:
    """Chooses one option after another: by a plan, or by chance; `taken` is the plan it made."""

    def __init__(self, plan: Plan = (), chance: Random | None = None) -> None:
        self._plan, self._chance = iter(plan), chance
        self.taken: Plan = ()

    def __call__(self, options: Sequence[T]) -> T:
        """Return an option; after the plan's end, the first."""
        last = len(options) - 1
        number = self._chance.randint(0, last) if self._chance else min(next(self._plan, 0), last)
        self.taken += (number,)
        return options[number]


@dataclass(frozen=True)
class Arena:
    """The worlds for an exercise's nodes, and the judgement of a drive in them."""

    contract: Contract
    field: bool = False  # also what only nodes with the badge field-ready have to cope with

    def world(self, draw: Draw) -> Scenario:
        """Return the world that these choices make."""
        if self.contract.goals:
            return _goals(draw, self.field)
        return _driving(draw, self.contract, self.field)


def arena_of(exercise: Exercise, *, field: bool = False) -> Arena:
    """Return the worlds and the contract of an exercise.

    Raises InputError: its nodes do not drive.
    """
    return Arena(driving_contract_of(exercise), field)


def _driving(draw: Draw, contract: Contract, field: bool) -> Scenario:
    """Draw a world of things that stand, and a lidar."""
    walls = (ROOM,) if draw(MAYBE) else ()
    boxes = tuple(box for _ in range(MOST_THINGS) for box in _thing(draw))
    return Scenario(
        title="",
        world=World(boxes=boxes, walls=walls),
        duration=contract.search_for,
        node=draw(contract.nodes),
        faults=_lidar_faults(draw, field),
        lidar=LidarSpec(profile=draw(LIDARS if field else LIDARS[:1])),
        qos=draw(QOS if field else QOS[:1]),
        raw=_raw(draw, contract.search_for) if contract.supervises else (),
        script=_e_stop(draw) if contract.supervises else (),
        odometry=OdometrySpec(enabled=False),
    )


def _thing(draw: Draw) -> tuple[Box, ...]:
    """Draw a box in the robot's way or beside it, or a long and thin one, a wall; or nothing."""
    there, wall = draw(MAYBE), draw(MAYBE)
    sizes, aside, turns = WALL if wall else BOX
    size, x, y = draw(sizes) / 10, draw(range(5, 21)) / 10, _signed(draw, aside)
    if draw(MAYBE) and not wall:  # as near to the way as it gets
        y = max(-3, min(3, y))
    box = Box(center=(x, y / 10), size=(size, THICK if wall else size), yaw_deg=draw(turns))
    return (box,) if there else ()


def _signed(draw: Draw, most: int) -> int:
    return draw((1, -1)) * draw(range(most + 1))


def _lidar_faults(draw: Draw, field: bool) -> Faults:
    """Draw nothing wrong in half of the worlds, else a little of it."""
    wrong, begin = draw(MAYBE), draw(range(6)) / 2  # [s]; 0: never
    faults = Faults(
        blackout=((begin, begin + SILENCE),) if begin else (),
        nan_speckle=draw((0.0, 0.02, 0.05)),
        scan_loss=draw(LOSS if field else LOSS[:1]),
        scan_latency=draw(LATE),
        range_noise=draw((0.0, 0.01)),
    )
    return faults if wrong else Faults()


def _raw(draw: Draw, duration: float) -> tuple[RawCommands, ...]:
    """Draw what a model asks for: a turn on the spot, or none, then straight ahead."""
    turn, first, then = draw((0.0, 1.0, -1.0, 3.0, -3.0)), draw(SPEEDS), draw(SPEEDS)
    phases = [(0.0, turn, 1.03)] if turn else []
    phases += [(first, 0.0, duration / 2 + 0.03)] if first != then else []
    phases += [(then, 0.0, duration)]
    begins = [0.33, *(end for *_, end in phases)]
    return tuple(
        RawCommands(begin=begin, end=end, linear_x=speed, angular_z=turning, rate=10.0)
        for begin, (speed, turning, end) in zip(begins, phases, strict=False)
    )


def _e_stop(draw: Draw) -> tuple[ScriptEvent, ...]:
    at = float(draw(range(6)))  # [s]; 0: never
    pressed = ScriptEvent(at=at, e_stop=True), ScriptEvent(at=at + E_STOP, e_stop=False)
    return pressed if at else ()


def _goals(draw: Draw, field: bool) -> Scenario:
    """Draw a start, and one goal or two, far enough from it and near enough to be reached."""
    two, lossy = draw(MAYBE), draw(MAYBE)
    yaw = draw((0.0, 90.0, -90.0, 180.0, 135.0, -135.0, 45.0, -45.0))
    places = [(_signed(draw, 3) / 2, _signed(draw, 3) / 2) for _ in range(3)][: 3 if two else 2]
    script = tuple(
        ScriptEvent(at=0.55 + 3.0 * i, goal=(*place, 0.0)) for i, place in enumerate(places[1:])
    )
    way = max(math.dist(place, places[-1]) for place in places)
    loss, late = draw(LOSS if field else LOSS[:1]), draw(LATE)
    return Scenario(
        title="",
        world=World(description="An open floor."),
        duration=round(script[-1].at + 8.0 + 4.0 * way, 1),  # even a slow turner arrives
        robot=RobotSpec(start=(*places[0], yaw)),
        script=script,
        lidar=LidarSpec(enabled=False),
        odometry=OdometrySpec(rate=draw((20.0, 100.0) if field else (20.0,))),
        faults=Faults(odom_loss=loss, odom_latency=late) if lossy else Faults(),
        qos=draw(QOS if field else QOS[:1]),
    )
