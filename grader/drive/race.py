"""A race: how a node drives in three worlds of its exercise, in figures. Nobody judges it.

A world's figure is the time from a goal until the robot is within `ARRIVED` of it [s], or, where
there are no goals, the way driven in the time that the world lasts [m]. A node that touches
something, dies or breaks a limit of its contract has none. How smoothly the robot drives is said by
the root mean square of its acceleration, as rides are judged (ISO 2631-1, here without weights for
frequencies): commands that come more often look no smoother.
"""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import Annotated, Any

import msgspec
import numpy as np
from msgspec import Meta

from grader.checks.contract import Contract
from grader.course.exercises import Exercise
from grader.drive.mishaps import TOUCHES, harm_of
from grader.errors import InputError
from grader.exercises import contract_of
from grader.recording import Recording
from rclpy_virtual_time import readable
from sim.clearance import FARTHEST
from sim.scenario_files import tables_of

ARRIVED = 0.5  # [m] from a goal, as the contract says it
ASKED = 0.2  # [m] of clearance, by the checks of the tasks
MOSTLY, LEAST = 0.6, 0.1  # of a loss: the part whose span is said, and the least that is [s], [m]
EVERY = 10  # samples of the truth, which are 20 ms apart: a track has 5 Hz
MOST_SAID = 100  # [characters] of why a race was not finished
GHOSTS = Path(__file__).with_name("ghosts.json")  # made by grader.authoring.ghosts

Name = Annotated[str, Meta(max_length=60)]
Digest = Annotated[str, Meta(pattern=r"\A[0-9a-f]{64}\Z")]
Figure = Annotated[float, Meta(ge=0.0, le=10_000.0)]
Track = dict[str, list[float]]  # t [s], x, y [m], yaw [rad]


class Lap(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """One world of a race; figures to 0.01 of their units."""

    world: Name  # the scenario
    of: Digest  # what the scenario says
    recording: Digest
    figure: Figure | None  # [s] or [m]; None: not finished
    ended: Annotated[str, Meta(max_length=MOST_SAID)]  # why it was not finished; else ""
    nearest: Figure | None  # least clearance [m]; None: there never was anything within 10 m
    median: Figure | None  # of the clearance [m]
    acceleration: Figure  # root mean square, forward [m/s²]
    turning: Figure  # root mean square of the angular acceleration [rad/s²]


def worlds_of(exercise: Exercise) -> tuple[str, ...]:
    """Return the scenarios of an exercise's race.

    Raises InputError: its nodes do not race.
    """
    if race := contract_of(exercise).race:
        return race
    why = "its node does not choose by itself how to drive"
    raise InputError(f"exercise {exercise.number} has no race: {why}")


def unit_of(exercise: Exercise) -> str:
    """Return the unit of an exercise's figures: "s", of which less is better, or "m"."""
    return "s" if contract_of(exercise).goals else "m"


def ranking_of(exercise: Exercise) -> str:
    """Return in words how the results of a race are ranked."""
    least = unit_of(exercise) == "s"
    return f"by the worlds finished, then {'the least' if least else 'the greatest'} sum"


def rules_of(exercise: Exercise) -> str:
    """Return in three lines what a finish is, what is too near, and how results are ranked."""
    contract = contract_of(exercise)
    limits = contract.limits
    asked = "" if contract.goals else f"; the tasks' checks ask for {ASKED} m"
    turn = f" or {limits.turning:g} rad/s" if limits.turning else ""
    most = f"{limits.slowest:g} to {limits.fastest:g} m/s{turn}"
    return (
        f"Finished: no touch, no death, no command beyond {most}.\n"
        f"Only what is touched was too near{asked}.\nRanked {ranking_of(exercise)}."
    )


def lap_of(recording: Recording, contract: Contract) -> Lap:
    """Return the figures of a drive."""
    truth = recording.truth
    figure, ended = None, ""
    if harm := harm_of(recording, contract):
        said = "touched something" if harm.kind == TOUCHES else harm.text.removeprefix("the node ")
        ended = f"{one_line(said)[: MOST_SAID - 12]} at {harm.at:.1f} s"
    elif not contract.goals:
        figure = float(np.hypot(np.diff(truth.x), np.diff(truth.y)).sum())
    elif (figure := _arrival(recording)) is None:
        ended = "did not come to its goal"
    near = truth.clearance if truth.clearance.min(initial=FARTHEST) < FARTHEST else np.empty(0)
    return Lap(
        world=recording.name,
        of=digest_of(recording.name),
        recording=recording.digest(),
        figure=None if figure is None else round(figure, 2),
        ended=ended,
        nearest=round(float(near.min()), 2) if len(near) else None,
        median=round(float(np.median(near)), 2) if len(near) else None,
        acceleration=_root_mean_square(truth.v, truth.t),
        turning=_root_mean_square(truth.w, truth.t),
    )


def track_of(recording: Recording) -> Track:
    """Return where the robot was, for a replay in which it drives along: five times a second."""
    truth = recording.truth
    columns = {"t": truth.t / 1e9, "x": truth.x, "y": truth.y, "yaw": truth.yaw}
    return {name: np.round(each[::EVERY], 2).tolist() for name, each in columns.items()}


def too_near(lap: Lap, contract: Contract) -> str:
    """Return that a drive was finished nearer to something than checks allow; "" if not."""
    if contract.goals or lap.figure is None or lap.nearest is None or lap.nearest >= ASKED:
        return ""
    return f"finished, though {lap.nearest:.2f} m is less than the {ASKED} m of the tasks' checks"


def loss_to(name: str, other: Track, recording: Recording, contract: Contract) -> str:
    """Return where a finished drive loses most to another of a name; "" if it does nowhere.

    Times are compared where both are equally far from the goal; ways, at the same time.
    """
    mine, goals = track_of(recording), recording.goals()
    if contract.goals:
        unit, goal = "s", (goals.x[-1], goals.y[-1])
        levels = np.linspace(min(_nears(each, goal)[0] for each in (mine, other)), ARRIVED, 100)
        at, there = (np.interp(-levels, -_nears(x, goal), x["t"]) for x in (mine, other))
        at, gap = np.append(goals.t[-1], at), np.append(0.0, at - there)
    else:
        at, unit = np.array(mine["t"]), "m"
        gap = np.interp(at, other["t"], _driven(other)) - _driven(mine)
    gains = np.triu(gap - gap[:, np.newaxis])  # from each moment to each later one
    most = gains.max(initial=0.0)
    if most < LEAST:
        return ""
    spans = np.where(gains >= MOSTLY * most, at - at[:, np.newaxis], np.inf)
    first, last = np.unravel_index(spans.argmin(), spans.shape)
    lost = f"{gains[first, last]:.1f} of {most:.1f} {unit} to {name}"
    return f"from {at[first]:.1f} to {at[last]:.1f} s it loses {lost}"


def _nears(track: Track, place: tuple[float, float]) -> Any:
    """Return the least distance from a place that there was by each moment [m]."""
    x, y = np.array(track["x"]) - place[0], np.array(track["y"]) - place[1]
    return np.minimum.accumulate(np.hypot(x, y))


def _driven(track: Track) -> Any:
    """Return the way driven by each moment [m]."""
    return np.append(0.0, np.hypot(np.diff(track["x"]), np.diff(track["y"])).cumsum())


def digest_of(world: str) -> str:
    """Return the fingerprint of what a scenario says."""
    tables = json.dumps(tables_of(world)[1], sort_keys=True)
    return hashlib.sha256(tables.encode()).hexdigest()


def reference_laps(slug: str) -> dict[str, tuple[Lap, Track]]:
    """Return the reference's lap and track in each world of an exercise's race."""
    made: dict[str, Any] = json.loads(GHOSTS.read_text("utf-8"))[slug]
    return {name: (msgspec.convert(each["lap"], Lap), each["track"]) for name, each in made.items()}


def one_line(text: str) -> str:
    """Return others' text as one line."""
    return " ".join(readable(text).split())


def _arrival(recording: Recording) -> float | None:
    """Return how long it took from the last goal until the robot was there [s]."""
    goals, truth = recording.goals(), recording.truth
    if not len(goals.t):
        return None
    times = truth.t / 1e9 - goals.t[-1]
    there = np.hypot(truth.x - goals.x[-1], truth.y - goals.y[-1]) <= ARRIVED
    at = np.flatnonzero(there & (times >= 0.0))
    return float(times[at[0]]) if len(at) else None


def _root_mean_square(speed: Any, t: Any) -> float:
    changes = np.diff(speed) / (np.diff(t) / 1e9)
    return round(float(np.sqrt(np.mean(changes**2))), 2) if len(changes) else 0.0
