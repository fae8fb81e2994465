"""`extends` in a scenario file: what is inherited, what is overridden, what is refused."""

from pathlib import Path

import msgspec
import pytest

from sim import scenario_files
from sim.errors import InputError
from sim.scenario import Scenario
from sim.scenario_files import load_scenario, scenario_from_toml, scenario_names
from sim.toml_input import parse_toml, read_toml
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
freeze = [[1.0, 2.0], [3.0, 4.0]]
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
def course(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Make a course of one scenario, `wall`, and return its folder."""
    monkeypatch.setattr(scenario_files, "SCENARIOS", ((tmp_path, "*/*.toml"),))
    folder = tmp_path / "walls"
    folder.mkdir()
    (folder / "wall.toml").write_text(BASE)
    return folder


def mine(course: Path, text: str) -> Scenario:
    path = course / "mine.toml"
    path.write_text(text)
    return load_scenario("mine")


def refusal(course: Path, text: str) -> str:
    """Return what is said of the file mine.toml, after its path."""
    with pytest.raises(InputError) as caught:
        mine(course, text)
    where, _, what = str(caught.value).partition("mine.toml: ")
    assert where == f"{course}/"
    return what


# --- what is inherited ---------------------------------------------------------------------------


def test_everything_but_name_title_and_description_is_inherited(course: Path) -> None:
    scenario, base = mine(course, HEAD), load_scenario("wall")

    assert (scenario.name, scenario.title, scenario.description) == ("mine", "Mine", "")
    own = {"name": "wall", "title": base.title, "description": base.description}
    assert msgspec.structs.replace(scenario, **own) == base


def test_a_value_is_overridden(course: Path) -> None:
    scenario = mine(course, HEAD + 'description = "Longer."\nduration = 12.0')

    assert (scenario.duration, scenario.seed, scenario.description) == (12.0, 5, "Longer.")


def test_tables_are_merged_key_by_key_at_any_depth(course: Path) -> None:
    scenario = mine(
        course,
        HEAD
        + '[robot]\nradius = 0.3\n[lidar]\nprofile = "wide"\n'
        + '[node.models."velocity_model.pkl".settings]\nseconds = 0.8',
    )

    assert (scenario.robot.radius, scenario.robot.max_linear) == (0.3, 0.4)
    assert (scenario.lidar.profile, scenario.lidar.rate) == ("wide", 5.0)
    model = scenario.node.models["velocity_model.pkl"]
    assert (model.probe, model.settings) == ("slow", {"seconds": 0.8, "scale": 0.04})


def test_a_table_that_the_base_lacks_is_added(course: Path) -> None:
    assert mine(course, HEAD + '[qos]\nsensors = "sensor_data"').qos.sensors == "sensor_data"
    assert load_scenario("wall").qos.sensors == "reliable"


def test_a_list_replaces_the_inherited_one_as_a_whole(course: Path) -> None:
    scenario = mine(
        course,
        HEAD + "raw = []\n[[script]]\nat = 3.0\ngoal = [3, 0, 0]\n[faults]\nfreeze = [[5.0, 6.0]]",
    )

    assert [event.at for event in scenario.script] == [3.0]
    assert scenario.raw == ()
    assert scenario.faults.freeze == ((5.0, 6.0),)


def test_a_world_in_the_file_is_merged_too(course: Path) -> None:
    scenario = mine(course, HEAD + "[world]\ncarts = []\npillars = [{ center = [1, 2] }]")

    world, base = scenario.world, load_scenario("wall").world
    assert (world.walls, world.carts, len(world.pillars)) == (base.walls, (), 1)


def test_a_name_replaces_a_world_in_the_file(course: Path) -> None:
    assert mine(course, HEAD + 'world = "hall"').world == load_world("hall")


def test_a_world_in_the_file_replaces_a_name(course: Path) -> None:
    (course / "wall.toml").write_text('title = "x"\nworld = "hall"')

    assert mine(course, HEAD + "[world]\nboxes = []").world.walls == ()


def test_a_file_elsewhere_extends_by_name_too(course: Path, tmp_path: Path) -> None:
    elsewhere = tmp_path / "wall.toml"  # of the same name as what it extends
    elsewhere.write_text(HEAD + "seed = 6")

    scenario = load_scenario(elsewhere)
    assert (scenario.name, scenario.seed, scenario.duration) == ("wall", 6, 9.0)
    assert scenario_from_toml(HEAD, "here").duration == 9.0


# --- what is refused -----------------------------------------------------------------------------


def test_an_unknown_scenario_gets_the_nearest_one(course: Path) -> None:
    assert refusal(course, 'title = "x"\nextends = "wal"') == (
        "extends = \"wal\": no scenario is called that; did you mean 'wall'?"
    )


@pytest.mark.parametrize("path", ["walls/wall", "../walls/wall", "wall.toml"])
def test_a_path_is_no_name(course: Path, path: str) -> None:
    said = refusal(course, f'title = "x"\nextends = "{path}"')

    assert said.startswith(f'extends = "{path}": no scenario is called that')


def test_what_is_no_text_is_no_name(course: Path) -> None:
    assert refusal(course, 'title = "x"\nextends = 3') == "extends = 3: expected a scenario's name"
    assert refusal(course, 'title = "x"\nextends = ["wall"]') == (
        'extends = ["wall"]: expected a scenario\'s name'
    )


def test_a_scenario_that_extends_itself_is_refused(course: Path) -> None:
    assert refusal(course, 'title = "x"\nextends = "mine"') == (
        "extends = \"mine\": 'mine' extends itself; expected a scenario that extends none"
    )


def test_a_circle_is_refused(course: Path) -> None:
    (course / "wall.toml").write_text('title = "x"\nextends = "mine"')

    assert refusal(course, HEAD) == (
        "extends = \"wall\": 'wall' extends 'mine'; expected a scenario that extends none"
    )


def test_a_chain_is_refused(course: Path) -> None:
    (course / "longer.toml").write_text('title = "x"\nextends = "wall"')

    assert refusal(course, 'title = "x"\nextends = "longer"') == (
        "extends = \"longer\": 'longer' extends 'wall'; expected a scenario that extends none"
    )


def test_a_title_of_its_own_is_required(course: Path) -> None:
    assert refusal(course, 'extends = "wall"') == "missing key 'title'"


def test_a_mistake_is_named_in_the_file_that_has_it(course: Path) -> None:
    assert refusal(course, HEAD + "duration = -1") == (
        "duration = -1: expected a number > 0 and <= 3600"
    )
    assert refusal(course, HEAD + "lidar = 3") == "lidar = 3: expected a table, got a whole number"
    (course / "wall.toml").write_text(BASE.replace("radius", "raduis"))
    with pytest.raises(InputError) as caught:
        mine(course, HEAD + "[robot]\nradius = 0.3")
    assert str(caught.value) == (
        f"{course / 'wall.toml'}: unknown key 'robot.raduis'; did you mean 'radius'?"
    )


# --- the scenarios of the course -----------------------------------------------------------------

EXTENDING = {
    name: path
    for name, path in scenario_names().items()
    if "extends" in parse_toml(read_toml(path), str(path))
}


@pytest.mark.parametrize("name", EXTENDING)
def test_a_scenario_of_the_course_extends_one_of_its_own_exercise(name: str) -> None:
    base = parse_toml(read_toml(EXTENDING[name]), name)["extends"]

    assert scenario_names()[base].parent == EXTENDING[name].parent


def test_a_field_scenario_is_its_base_with_another_lidar() -> None:
    wide, base = load_scenario("detect_field_wide"), load_scenario("detect_field_lds01")

    assert (wide.lidar.profile, base.lidar.profile) == ("wide", "lds01")
    assert (wide.program, wide.node, wide.world) == (base.program, base.node, base.world)
