"""Every mistake in a scenario or world file gives one line: where, what, and what was expected.

`sim.toml_input.convert` and `sim.errors` are tested through this file.
"""

import copy
import json

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from simulated import CLUTTER, INLINE, refusal

from sim import scenario_files
from sim import world as world_module
from sim.errors import InputError
from sim.scenario_files import load_scenario, scenario_from_json, scenario_from_toml, scenario_names

HEAD = 'title = "x"\nworld = "hall"\n'

MISTAKES = {  # what is said: of which file
    "missing key 'title'": 'world = "hall"',
    "missing key 'world' (a world's name, or a table; `extends` inherits one)": 'title = "x"',
    "unknown key 'duraton'; did you mean 'duration'?": HEAD + "duraton = 3",
    "unknown key 'qos.xyz'; there is: sensors": HEAD + "[qos]\nxyz = 1",
    "unknown key 'name': the name of a scenario is that of its file": HEAD + 'name = "a"',
    'duration = "long": expected a number, got a string': HEAD + 'duration = "long"',
    "duration = inf: expected a number > 0 and <= 3600": HEAD + "duration = inf",
    "world = \"hal\": no world is called that; did you mean 'hall'?": 'title = "x"\nworld = "hal"',
    "world = 3: expected a world's name or a table": 'title = "x"\nworld = 3',
    "robot.name = \"turtlebot3\": no robot is called that; did you mean 'turtlebot4'?":
        HEAD + 'robot.name = "turtlebot3"',
    "lidar.limits = [5.0, 0.3]: expected range_min below range_max":
        HEAD + "[lidar]\nlimits = [5.0, 0.3]",
    'qos.sensors = "best": expected one of reliable, sensor_data': HEAD + '[qos]\nsensors = "best"',
    "script[0]: expected at and exactly one of goal, odom, teleport and e_stop":
        HEAD + "[[script]]\nat = 1",
    "script[0]: unstamped and stamp_offset are said of goals, w of goals and odom":
        HEAD + "[[script]]\nat = 1\nteleport = [1, 2, 3]\nunstamped = true",
    "script[0]: expected unstamped or stamp_offset, not both":
        HEAD + "[[script]]\nat = 1\ngoal = [1, 2, 3]\nunstamped = true\nstamp_offset = 2.0",
    "faults.blackout = [[2, 1]]: expected [begin, end] with begin < end":
        HEAD + "[faults]\nblackout = [[2, 1]]",
    "expected at most 20000 bench scans, got 30000": HEAD + "[[bench]]\nrepeat = 10000\n" * 3,
    "world.walls[0].points = [[0, 0]]: expected a list of at least 2 values, got 1":
        INLINE + "[[world.walls]]\npoints = [[0, 0]]",
    "world.walls[0].points = [[0, 0], [0, 0]]: expected each at least 0.001 m from the one before":
        INLINE + "[[world.walls]]\npoints = [[0, 0], [0, 0]]",
    "world.clutter[0].area = [[1, 1], [0, 2]]: "
    "expected [[x0, y0], [x1, y1]] with x0 < x1 and y0 < y1":
        INLINE + "[[world.clutter]]\narea = [[1, 1], [0, 2]]\ncount = 1",
    "world.clutter[0].size = [0.6, 0.2]: expected [shortest, longest]":
        CLUTTER + "count = 1\nsize = [0.6, 0.2]",
    "world: expected at most 2000 obstacles in a world, got 2001":
        CLUTTER + "count = 2000\n[[world.pillars]]\ncenter = [0, 0]",
    "world.carts[0].path = [[0, 0, 0], [0, 1, 1]]: expected increasing times, got 0.0 after 0.0":
        INLINE + "[[world.carts]]\nsize = [1, 1]\npath = [[0, 0, 0], [0, 1, 1]]",
    "world.carts[0].path = [[0, 0, 0], [1, 9, 0]]: expected at most 2.0 m/s, got 9 m/s at 0.0 s":
        INLINE + "[[world.carts]]\nsize = [1, 1]\npath = [[0, 0, 0], [1, 9, 0]]",
    "world.carts[0].path = [[0, 0, 0], [1, 1, 0]]: expected a loop to end where it begins":
        INLINE + "[[world.carts]]\nsize = [1, 1]\npath = [[0, 0, 0], [1, 1, 0]]\nloop = true",
    "program[0]: expected a file with supplied = true": HEAD + "[[program]]\nsupplied = true",
    "duration = 1" + 58 * "0" + "…: number out of range": HEAD + "duration = 1" + 400 * "0",
    "not valid TOML: Invalid value (at end of document)": HEAD + "robot = [",
}  # fmt: skip


@pytest.mark.parametrize("message", MISTAKES)
def test_a_mistake_gives_one_clear_line(message):
    said = refusal(scenario_from_toml, MISTAKES[message], "mine.toml")
    assert said == f"mine.toml: {message}"


def test_goals_and_scripted_poses_may_be_infinite_but_nothing_else():
    text = HEAD + (
        "[[script]]\nat = 1\ngoal = [nan, inf, 0]\n[[script]]\nat = 2\nodom = [-inf, 0, nan]\n"
        "[[bench]]\nfill = nan\npatches = [{from_deg = 0, to_deg = 1, range = -inf}]\n"
    )
    assert len(scenario_from_toml(text, "x").script) == 2


def test_a_file_that_can_not_be_read_is_named(tmp_path):
    (tmp_path / "folder.toml").mkdir()
    (tmp_path / "photo.toml").write_bytes(b"\x89PNG\xff")
    (tmp_path / "huge.toml").write_bytes(b"#" * 4_000_001)
    for name, said in {
        "none": "cannot read this file: no such file or directory",
        "folder": "cannot read this file: is a directory",
        "photo": "not UTF-8 text (byte 0)",
        "huge": "4000001 bytes, expected at most 4000000",
    }.items():
        path = tmp_path / f"{name}.toml"
        assert refusal(load_scenario, path) == f"{path}: {said}"


def test_an_unknown_name_gets_the_nearest_one():
    said = refusal(load_scenario, "demo_wal")
    assert said == "no scenario is called 'demo_wal'; did you mean 'demo_wall'?"


def test_a_broken_world_file_is_named(tmp_path, monkeypatch):
    monkeypatch.setattr(world_module, "WORLDS", tmp_path)
    (tmp_path / "cellar.toml").write_text("pilars = []\n")
    said = refusal(scenario_from_toml, 'title = "x"\nworld = "cellar"', "mine.toml")
    assert said == f"{tmp_path / 'cellar.toml'}: unknown key 'pilars'; did you mean 'pillars'?"


def test_two_scenarios_of_one_name_are_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(scenario_files, "SCENARIOS", ((tmp_path, "*/*.toml"),))
    for folder in ("one", "two"):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "wall.toml").write_text(HEAD)
    one, two = (tmp_path / folder / "wall.toml" for folder in ("one", "two"))
    assert refusal(scenario_names) == f"two scenarios are called 'wall': {one} and {two}"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{", "not valid JSON: Expecting property name"),
        ("[]", "expected a JSON object"),
        ('{"title": "x", "world": {}, "sead": 1}', "unknown key 'sead'; did you mean 'seed'?"),
    ],
)
def test_broken_json_gives_one_line_too(text, message):
    assert refusal(scenario_from_json, text).startswith(f"scenario: {message}")


RICH = {
    "title": "x",
    "seed": 1,
    "duration": 2.0,
    "world": {
        "walls": [{"points": [[0, 1], [2, 3]], "closed": False}],
        "boxes": [{"center": [1, 1], "size": [1, 1], "yaw_deg": 0}],
        "clutter": [{"area": [[0, 0], [1, 1]], "count": 1, "size": [0.1, 0.2]}],
        "carts": [{"size": [1, 1], "path": [[0, 0, 0], [1, 1, 0]], "loop": False}],
    },
    "robot": {"start": [0, 0, 0], "radius": 0.2},
    "lidar": {"profile": "lds01", "rate": 5},
    "faults": {"blackout": [[0, 1]], "scan_loss": 0.5},
    "qos": {"sensors": "reliable"},
    "script": [{"at": 1, "goal": [0, 0, 0]}],
    "bench": [{"tags": ["slow"], "patches": [{"from_deg": 0, "to_deg": 1, "range": 2}]}],
}


def places(doc, key=()):
    """Return the keys of everything in a document, itself excepted."""
    found = []
    if isinstance(doc, list):
        doc = dict(enumerate(doc))
    for name, value in doc.items() if isinstance(doc, dict) else ():
        found += [(*key, name), *places(value, (*key, name))]
    return found


anything = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=4),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=4), inner),
    max_leaves=5,
)


@settings(derandomize=True, deadline=None, max_examples=60)
@given(st.sampled_from(places(RICH)), anything, st.text(max_size=4) | st.none())
def test_whatever_stands_anywhere_gives_a_scenario_or_one_line(key, value, new_key):
    doc = copy.deepcopy(RICH)
    place = doc
    for part in key[:-1]:
        place = place[part]
    if isinstance(place, dict) and new_key is not None:
        place[new_key] = value
    else:
        place[key[-1]] = value
    try:
        scenario_from_json(json.dumps(doc))
    except InputError as error:
        assert len(str(error).splitlines()) == 1
        assert str(error).startswith("scenario: ")
