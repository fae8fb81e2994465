"""How hard is a run? Four numbers that keep the worlds of different students comparable.

| number       | unit  | harder when | what it is                                             |
|--------------|-------|-------------|--------------------------------------------------------|
| `free_way`   | m     | smaller     | free distance straight ahead of the start              |
| `width`      | m     | smaller     | the narrowest place along it                           |
| `clutter`    | 0 – 1 | greater     | share of the surroundings where the robot hardly fits  |
| `tortuosity` | rad/m | greater     | turning per metre on straight lines through the goals  |

They take only static obstacles into account: carts are the same with every seed.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from sim.clearance import clearance
from sim.layout import Layout
from sim.placement import scenario_layout
from sim.scenario import Scenario

WAY = 6.0  # [m] to look ahead
SURROUNDINGS = 4.0  # [m] around the start
STEP = 0.1  # [m]
ELBOW_ROOM = 0.15  # [m]
SCALE = (2.0, 0.5, 0.1, 0.5)  # differences of the four numbers that weigh the same


@dataclass(frozen=True)
class Difficulty:
    """See the table above."""

    free_way: float  # [m], at most 6
    width: float  # [m]
    clutter: float  # 0 – 1
    tortuosity: float  # [rad/m]

    def distance(self, other: Difficulty) -> float:
        """Return how different two runs are; 1 is a large difference in one of the numbers."""
        mine = (self.free_way, self.width, self.clutter, self.tortuosity)
        theirs = (other.free_way, other.width, other.clutter, other.tortuosity)
        return sum(abs(a - b) / s for a, b, s in zip(mine, theirs, SCALE, strict=True))


def difficulty(scenario: Scenario, seed: int) -> Difficulty:
    """Return how hard a scenario is with this seed."""
    layout, radius = scenario_layout(scenario, seed), scenario.robot.radius
    free_way, width = _way_ahead(layout, radius)
    return Difficulty(free_way, width, _clutter(layout, radius), _tortuosity(scenario, layout))


def comparable_seed(scenario: Scenario, seeds: Sequence[int]) -> int:
    """Return which of the seeds makes the scenario most nearly as hard as its own does.

    For a scenario without random geometry it is the first.
    """
    if not scenario.world.clutter and scenario.robot.start_jitter == (0.0, 0.0, 0.0):
        return seeds[0]
    own = difficulty(scenario, scenario.seed)
    return min(seeds, key=lambda seed: own.distance(difficulty(scenario, seed)))


def _way_ahead(layout: Layout, radius: float) -> tuple[float, float]:
    x, y, yaw = layout.start
    s = np.arange(0.0, WAY, STEP)
    points = np.column_stack((x + s * math.cos(yaw), y + s * math.sin(yaw)))
    room = clearance(layout, np.zeros(len(s)), points, radius)
    blocked = np.flatnonzero(room <= 0.0)
    end = int(blocked[0]) if len(blocked) else len(s)
    # the last metre narrows to nothing at the obstacle itself
    sides = room[: max(1, end - round(1.0 / STEP))]
    return float(s[end - 1]) if end else 0.0, float(2 * (sides.min() + radius))


def _clutter(layout: Layout, radius: float) -> float:
    x, y, _ = layout.start
    side = np.arange(-SURROUNDINGS, SURROUNDINGS, 4 * STEP)
    grid = np.array([(x + dx, y + dy) for dx in side for dy in side])
    room = clearance(layout, np.zeros(len(grid)), grid, radius)
    return float(np.mean(room < ELBOW_ROOM))


def _tortuosity(scenario: Scenario, layout: Layout) -> float:
    x, y, heading = layout.start
    turned = travelled = 0.0
    for event in scenario.script:
        if event.goal is None or not all(math.isfinite(value) for value in event.goal[:2]):
            continue
        dx, dy = event.goal[0] - x, event.goal[1] - y
        bearing = math.atan2(dy, dx)
        turned += abs(math.remainder(bearing - heading, math.tau))
        travelled += math.hypot(dx, dy)
        x, y, heading = event.goal[0], event.goal[1], bearing
    return turned / travelled if travelled else 0.0
