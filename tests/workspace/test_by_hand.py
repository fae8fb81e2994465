"""What a person does by hand in a page's drive, and the scenario that keeps it."""

from __future__ import annotations

import pickle
from pathlib import Path
from typing import Any

import pytest
from test_drives import said_by_page

from grader import drive
from grader.course.exercises import find_exercise
from grader.course.submission import find_submission
from grader.drive.by_hand import scenario_by_hand
from grader.recording import Recording, views
from rclpy_virtual_time.link.hosts import ForkServer
from sim.messages import GOAL_TOPIC
from sim.scenario_files import load_scenario, scenario_from_toml, scenario_names
from sim.simulation import Simulation

KNOB = {
    "node": "/live_parameters_agent", "name": "cruise_speed", "kind": "double", "fixed": False,
    "about": "speed where the way is free [m/s]", "limits": ["0.0", "0.5", "0.0"],
    "values": [[0.0, "0.3"], [4.2, "0.1"]],
}  # fmt: skip
REASON = "slow_distance (0.4 m) must not be below stop_distance (0.5 m)"


def sets(at: float, text: str, node: str = "/live_parameters_agent") -> dict[str, Any]:
    return {"at": at, "node": node, "sets": text}


DRIVEN: list[tuple[str, str, list[dict[str, Any]]]] = [
    ("live_parameters", "demo_wall", [
        sets(4.2, "cruise_speed:=0.1"), sets(2.5, "slow_distance:=0.4"),
        {"at": 3.0, "e_stop": True}, {"at": 3.5, "goal": [1.5, -0.25]},
        {"at": 5.0, "covers": 1.0}, {"at": 0.0, "box": [5.0, 1.5]},
    ]),
    # it has a setter of its own; the other extends another scenario
    ("live_parameters", "live_wall", [sets(1.5, "cruise_speed:=fast")]),
    ("live_parameters", "live_pairs", [sets(3.6, "cruise_speed:=0.45")]),
    ("three_nodes", "demo_wall", [
        sets(2.0, "cruise_speed:=0.1", "/shuttle/driver"),
        sets(2.0, "max_speed:=0.2", "/shuttle/guard"),
    ]),
]  # fmt: skip


def test_what_is_saved_drives_again_to_the_same_digest(
    forkserver: ForkServer, tmp_path: Path
) -> None:
    done = []
    for number, (slug, name, deeds) in enumerate(DRIVEN):
        files = find_exercise(slug).files
        node, folder = find_exercise(slug).solutions / files[0], tmp_path / str(number)
        of_page = {"tell": True, "others": files}  # of an exercise's, or of a program's
        more = of_page if number else {"arguments": "--scenario another"}
        order = {"file": str(node), "scenario": name, "deeds": deeds, **more}
        [said] = said_by_page(folder, [order])
        saved = folder / f"{name}_by_hand.toml"
        here: Recording = pickle.loads(saved.with_suffix(".pickle").read_bytes())[0]
        submission = drive.unpacked(find_submission(node, files[0], files[1:]), forkserver)
        there = drive.drive_node(submission, drive.scenario_for(str(saved)), forkserver)
        assert here.digest() == there.digest(), saved.read_text("utf-8")
        assert said["scenario"] == saved.stem == there.name
        done.append(said["hand"])
    told = [[(d["at"], d["text"], d["said"]) for d in each["done"]] for each in done]
    assert told[0] == [
        (2.5, "slow_distance:=0.4", f"refused: {REASON}"),
        (3.0, "e-stop pressed", ""),
        (4.2, "cruise_speed:=0.1", "accepted"),
    ]
    assert len(told[1]) == 6
    assert told[1][1][2].startswith("refused: Wrong parameter type")
    assert [answer for *_, answer in (told[2][-1], *told[3])] == ["accepted"] * 3
    assert done[0]["knobs"][0] == KNOB
    assert "/scan" in done[0]["hears"]


def test_each_scenario_takes_what_is_done_by_hand(tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    deeds = [sets(2.5, "speed:=0.2", "/a"), sets(1.5, "speed:=0.1", "/b"),
             {"at": 2.0, "goal": [1.5, -0.25]}, {"at": 0.0, "box": [2.0, 1.0]}]  # fmt: skip
    for name in scenario_names():
        own = load_scenario(name)
        file.write_text(scenario_by_hand(name, deeds), "utf-8")
        mine = load_scenario(file)
        assert mine.program[-1].arguments == ("/b", "1.5 speed:=0.1")
        assert mine.world.boxes[:-1] == own.world.boxes
        changed = {"name", "title", "program", "script", "world"}
        for field in set(own.__struct_fields__) - changed:  # NaN is unlike itself
            assert repr(getattr(mine, field)) == repr(getattr(own, field)), (name, field)


@pytest.mark.parametrize("name", ["demo_cart_from_the_left", "goal_field_mirrored"])
def test_a_goal_is_sent_where_somebody_clicked_on_a_turned_map(name: str) -> None:
    text = scenario_by_hand(name, [{"at": 2.0, "goal": [1.0, 3.0]}])
    simulation = Simulation(scenario_from_toml(text, "mine"))
    sent = [m for m in simulation.advance(2 * 10**9, []) if m.topic == GOAL_TOPIC]
    goals = views.goals(sent[-1:])
    assert (goals.x[0], goals.y[0]) == pytest.approx((1.0, 3.0), abs=0.001)
