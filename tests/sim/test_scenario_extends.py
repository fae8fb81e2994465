"""`extends` in a scenario file: what is inherited, what is overridden, what is refused."""

from pathlib import Path

import msgspec
import pytest
from simulated import refusal

from sim.scenario import Scenario
from sim.scenario_files import load_scenario, scenario_from_toml
from sim.world import load_world

BASE = """
title = "A wall"
description = "A wall, a cart and a goal."
seed = 5
duration = 9.0
raw = [{ from = 1.0, to = 2.0 }, { from = 3.0, to = 4.0 }]
script = [{ at = 1.0, goal = [1, 0, 0] }, { at = 2.0, goal = [2, 0, 0] }]
[robot]
radius = 0.2
max_linear = 0.4
[lidar]
rate = 5.0
[faults]
blackout = [[1.0, 2.0], [3.0, 4.0]]
[world]
description = "A wall."
walls = [{ points = [[2, -1], [2, 1]] }]
[[world.carts]]
size = [0.4, 0.4]
path = [[0, 5, 5], [4, 5, 6]]
[node.models."velocity_model.pkl"]
probe = "slow"
settings = { seconds = 0.2, scale = 0.04 }
"""
HEAD = 'title = "Mine"\nextends = "wall"\n'


@pytest.fixture
def course(course: Path) -> Path:
    """Put a scenario into the folder that can be extended."""
    (course / "wall.toml").write_text(BASE)
    return course


def mine(course: Path, text: str) -> Scenario:
    path = course / "mine.toml"
    path.write_text(text)
    return load_scenario("mine")


# --- what is inherited ---------------------------------------------------------------------------


def test_everything_but_name_title_and_description_is_inherited(course: Path) -> None:
    scenario, base = mine(course, HEAD), load_scenario("wall")

    assert (scenario.name, scenario.title, scenario.description) == ("mine", "Mine", "")
    own = {"name": "wall", "title": base.title, "description": base.description}
    assert msgspec.structs.replace(scenario, **own) == base


def test_tables_are_merged_at_any_depth_and_anything_else_is_replaced(course: Path) -> None:
    scenario = mine(
        course,
        HEAD
        + 'description = "Longer."\nduration = 12.0\nraw = []\n'
        + "[[script]]\nat = 3.0\ngoal = [3, 0, 0]\n[faults]\nblackout = [[5.0, 6.0]]\n"
        + '[robot]\nradius = 0.3\n[lidar]\nprofile = "wide"\n[qos]\nsensors = "sensor_data"\n'
        + '[node.models."velocity_model.pkl".settings]\nseconds = 0.8',
    )

    assert (scenario.duration, scenario.seed, scenario.description) == (12.0, 5, "Longer.")
    assert (scenario.robot.radius, scenario.robot.max_linear) == (0.3, 0.4)
    assert (scenario.lidar.profile, scenario.lidar.rate) == ("wide", 5.0)
    assert (scenario.qos.sensors, load_scenario("wall").qos.sensors) == ("sensor_data", "reliable")
    model = scenario.node.models["velocity_model.pkl"]
    assert (model.probe, model.settings) == ("slow", {"seconds": 0.8, "scale": 0.04})
    assert [event.at for event in scenario.script] == [3.0]
    assert (scenario.raw, scenario.faults.blackout) == ((), ((5.0, 6.0),))


def test_a_world_in_the_file_is_merged_too(course: Path) -> None:
    scenario = mine(course, HEAD + "[world]\ncarts = []\npillars = [{ center = [1, 2] }]")

    world, base = scenario.world, load_scenario("wall").world
    assert (world.walls, world.carts, len(world.pillars)) == (base.walls, (), 1)


def test_a_world_by_name_and_one_in_the_file_replace_each_other(course: Path) -> None:
    assert mine(course, HEAD + 'world = "hall"').world == load_world("hall")
    (course / "wall.toml").write_text('title = "x"\nworld = "hall"')
    assert mine(course, HEAD + "[world]\nboxes = []").world.walls == ()


def test_a_file_elsewhere_extends_by_name_too(course: Path, tmp_path: Path) -> None:
    elsewhere = tmp_path / "wall.toml"  # of the same name as what it extends
    elsewhere.write_text(HEAD + "seed = 6")

    scenario = load_scenario(elsewhere)
    assert (scenario.name, scenario.seed, scenario.duration) == ("wall", 6, 9.0)
    assert scenario_from_toml(HEAD, "here").duration == 9.0


# --- what is refused -----------------------------------------------------------------------------


NONE = "no scenario is called that"
REFUSED = {
    'title = "x"\nextends = "wal"': f"extends = \"wal\": {NONE}; did you mean 'wall'?",
    'title = "x"\nextends = "walls/wall"': f'extends = "walls/wall": {NONE}',  # a path
    'title = "x"\nextends = "wall.toml"': f'extends = "wall.toml": {NONE}',
    'title = "x"\nextends = 3': "extends = 3: expected a scenario's name",
    'extends = "wall"': "missing key 'title'",
    'title = "x"\nextends = "mine"': (
        "extends = \"mine\": 'mine' extends itself; expected a scenario that extends none"
    ),
    'title = "x"\nextends = "longer"': (
        "extends = \"longer\": 'longer' extends 'wall'; expected a scenario that extends none"
    ),
    HEAD + "duration = -1": "duration = -1: expected a number > 0 and <= 3600",
    HEAD + "lidar = 3": "lidar = 3: expected a table, got a whole number",
}


@pytest.mark.parametrize("text", REFUSED)
def test_what_can_not_be_extended_is_said(course: Path, text: str) -> None:
    (course / "longer.toml").write_text('title = "x"\nextends = "wall"')
    assert refusal(mine, course, text).startswith(f"{course}/mine.toml: {REFUSED[text]}")


def test_a_circle_is_refused(course: Path) -> None:
    (course / "wall.toml").write_text('title = "x"\nextends = "mine"')
    said = "extends = \"wall\": 'wall' extends 'mine'; expected a scenario that extends none"
    assert refusal(mine, course, HEAD) == f"{course}/mine.toml: {said}"


def test_a_mistake_of_the_base_is_named_in_its_file(course: Path) -> None:
    (course / "wall.toml").write_text(BASE.replace("radius", "raduis"))
    said = refusal(mine, course, HEAD + "[robot]\nradius = 0.3")
    assert said == f"{course}/wall.toml: unknown key 'robot.raduis'; did you mean 'radius'?"
