"""What the node of an exercise is, as one value: its limits, its period, and where it is tried.

Each exercise's `contract.py` has one, called `CONTRACT`, beside its oracle `cases`. Checks, search,
causes and mutants read it; nothing states a limit of a command a second time.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from grader.checks.ahead import front_distances
from grader.recording import Scan
from sim.scenario import NodeSpec, Scenario

Free = Callable[[Scenario, Scan], bool]
RACE = ("demo_race_corridor", "demo_race_cart", "demo_race_leader")  # straight ahead, by /scan


@dataclass(frozen=True)
class Limits:
    """What a contract says of every command."""

    slowest: float = 0.0  # [m/s]
    fastest: float = 0.5  # [m/s]
    turning: float = 0.0  # [rad/s] to either side
    rise: float | None = None  # [m/s] of linear.x from one command to the next


@dataclass(frozen=True)
class Contract:
    """What a node of an exercise does in any fair world."""

    limits: Limits = Limits()
    period: float | None = None  # [s] from one command to the next; None: one for each scan
    drives: bool = True  # by itself: worlds can be searched for it
    free: Free | None = None  # may the robot drive, seeing this? None: there is a goal instead
    patience: float = 3.0  # [s] that it may stand though its way is free
    heeds_e_stop: bool = False
    goals: bool = False  # the searched worlds have goals
    supervises: bool = False  # they have a model that never brakes, and emergency stops
    nodes: tuple[NodeSpec, ...] = (NodeSpec(),)  # what the node finds there: its models
    search_for: float = 9.0  # [s] that a searched world lasts
    race: tuple[str, ...] = ()  # the scenarios of three worlds, for a node that chooses its speed


def free_from(distance: float) -> Free:
    """Return whether nothing ahead is nearer than a distance [m]."""

    def free(scenario: Scenario, scan: Scan) -> bool:
        seen = front_distances(scan)
        return all(nearest is not None and nearest >= distance for nearest in seen)

    return free
