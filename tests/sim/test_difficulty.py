"""How hard is a run? The measure, and the choice of comparable seeds."""

import numpy as np
import pytest

from sim.difficulty import comparable_seed, difficulty
from sim.scenario_files import load_scenario, scenario_from_toml

SENSORLESS = "[lidar]\nenabled = false\n[odometry]\nenabled = false\n"


def scenario(world: str, rest: str = ""):
    return scenario_from_toml(f'title = "t"\n{rest}\n{SENSORLESS}[world]\n{world}', "here")


def test_an_open_world_is_the_easiest() -> None:
    easy = difficulty(scenario(""), 1)

    assert easy.free_way == pytest.approx(5.9)
    assert easy.clutter == 0.0
    assert easy.tortuosity == 0.0


WALLS = "walls = [{ points = [[-3, 0.6], [9, 0.6]] }, { points = [[-3, -0.6], [9, -0.6]] }]"
BOXES = "clutter = [{ area = [[-3, -3], [3, 3]], count = 15, size = [0.3, 0.6] }]"
BACK = "script = [{ at = 1.0, goal = [2, 0, 0] }, { at = 5.0, goal = [0, 0, 0] }]"


def test_what_stands_in_the_way_counts() -> None:
    ahead = difficulty(scenario("walls = [{ points = [[2.0, -3.0], [2.0, 3.0]] }]"), 1)
    assert ahead.free_way == pytest.approx(2.0 - 0.17, abs=0.11)
    assert difficulty(scenario(WALLS), 1).width == pytest.approx(1.2, abs=1e-6)
    assert difficulty(scenario(BOXES), 1).clutter > 0.1
    assert difficulty(scenario("", BACK), 1).tortuosity == pytest.approx(np.pi / 4)


def test_comparable_worlds_differ_and_are_about_as_hard() -> None:
    store = load_scenario("avoid_store")
    own = difficulty(store, store.seed)
    plain = [own.distance(difficulty(store, 1_000 * i)) for i in range(1, 9)]
    seeds = [comparable_seed(store, [1_000 * i + n for n in range(6)]) for i in range(1, 9)]
    chosen = [own.distance(difficulty(store, seed)) for seed in seeds]

    assert len(set(seeds)) == len(seeds)
    assert np.mean(chosen) < 0.7 * np.mean(plain)


def test_without_random_geometry_the_seed_stays() -> None:
    assert comparable_seed(scenario(""), [4711, 1, 2]) == 4711
