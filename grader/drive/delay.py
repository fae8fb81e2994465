"""How late may sensors and commands be? The largest delay that a node survives.

A node drives in the closed-loop worlds of its exercise, with every scan and odometry message late
by 0 to 300 ms, and then with every command late by as much. It survives a delay if in no world it
touches anything or dies, and comes to its goals. Where a world has none, the margin is what it
keeps clear of obstacles; with goals it is the time that is left.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from msgspec.structs import replace

from grader.checks.contract import Contract, Survived
from grader.course.exercises import Exercise
from grader.drive.mishaps import (
    ARRIVED,
    DIES,
    LOST,
    STANDS,
    TOUCHES,
    Mishap,
    mishap_of,
)
from grader.errors import InputError
from grader.exercises import driving_contract_of
from grader.recording import Recording
from sim.scenario import Scenario
from sim.scenario_files import load_scenario

HARM, ASTRAY = (DIES, TOUCHES), (DIES, TOUCHES, STANDS, LOST)
SENSORS, COMMANDS = "sensors", "commands"
AXES = (SENSORS, COMMANDS)
DELAYS = tuple(range(0, 301, 25))  # [ms]

Drive = Callable[[Scenario], Recording]
OnDrive = Callable[[int, int], None]  # drives that are over, of


@dataclass(frozen=True)
class Tried:
    """What became of a node with one delay, in the worst of its worlds."""

    delay: int  # [ms]
    margin: float  # [m] clear, or [s] left
    where: str  # the world
    mishap: Mishap | None  # that it does not survive

    @property
    def failed(self) -> str:
        """What went wrong, in a student's words; empty if nothing did."""
        if self.mishap is None:
            return ""
        text = self.mishap.text.replace("touches it", "touches something")
        return f"{text} ({self.where}, {self.mishap.at:.1f} s)"


@dataclass(frozen=True)
class Delays:
    """How a node takes delays."""

    exercise: Exercise
    tried: dict[str, tuple[Tried, ...]]  # by axis
    unit: str  # of the margins

    @property
    def survived(self) -> Survived:
        """The largest delays up to which the node survives every one."""
        return Survived(*(_largest(self.tried[axis]) for axis in AXES))


def delays(
    exercise: Exercise,
    drive: Drive,
    *,
    steps: Sequence[int] = DELAYS,
    on_drive: OnDrive = lambda done, of: None,
) -> Delays:
    """Drive a node of an exercise with every delay.

    Parameters
    ----------
    drive
        Drives the node in a scenario.
    steps
        Delays to try [ms]; the first is 0.
    on_drive
        Is told after each drive how many are over, and of how many.

    Raises
    ------
    InputError
        The exercise's nodes do not drive, its contract names no scenarios, or this node can't be
        driven in virtual time.
    """
    contract = driving_contract_of(exercise)
    if not contract.delayed_in:
        raise InputError(f"{exercise.slug}: its contract.py names no scenarios in delayed_in")
    worlds = [load_scenario(name) for name in contract.delayed_in]
    total, done = len(worlds) * (2 * len(steps) - 1), 0
    tried: dict[str, tuple[Tried, ...]] = {}
    for axis in AXES:
        rows = list(tried[SENSORS][:1]) if tried else []  # without delay both are the same
        for step in steps[len(rows) :]:
            found = []
            for world in worlds:
                recording = drive(delayed(world, axis, step))
                found.append(_judged(recording, contract, step))
                done += 1
                on_drive(done, total)
            rows.append(min(found, key=lambda one: (one.mishap is None, one.margin)))
        tried[axis] = tuple(rows)
    return Delays(exercise, tried, "s" if contract.free is None else "m")


def delayed(scenario: Scenario, axis: str, delay: int) -> Scenario:
    """Return a scenario in which sensors or commands come that much later [ms]."""
    late = delay / 1000
    faults = scenario.faults
    if axis == COMMANDS:
        return replace(scenario, faults=replace(faults, command_latency=late))
    return replace(scenario, faults=replace(faults, scan_latency=late, odom_latency=late))


def _judged(recording: Recording, contract: Contract, delay: int) -> Tried:
    mishap = mishap_of(recording, contract, HARM if contract.free else ASTRAY)
    if contract.free is None:
        margin = recording.scenario.duration - _arrival(recording)
    else:
        margin = float(recording.truth.clearance.min())
    return Tried(delay, 0.0 if mishap else margin, recording.name, mishap)


def _arrival(recording: Recording) -> float:
    """Return when the robot first came to its last goal [s]; inf: never."""
    goals, truth = recording.goals(), recording.truth
    if not len(goals.t):
        return math.inf
    away = np.hypot(truth.x - goals.x[-1], truth.y - goals.y[-1])
    there = np.flatnonzero((truth.t / 1e9 >= goals.t[-1]) & (away <= ARRIVED))
    return float(truth.t[there[0]] / 1e9) if len(there) else math.inf


def _largest(tried: Sequence[Tried]) -> int:
    largest = -1
    for one in tried:
        if one.mishap is not None:
            break
        largest = one.delay
    return largest
