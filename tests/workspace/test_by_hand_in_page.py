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
TWO = "stop_distance:=0.6"
REASON = "slow_distance (0.4 m) must not be below stop_distance (0.5 m)"


def sets(at: float, text: str, node: str = "/live_parameters_agent") -> dict[str, Any]:
    return {"at": at, "node": node, "sets": text}


DRIVEN: list[tuple[str, str, list[dict[str, Any]]]] = [
    ("live_parameters", "demo_wall", [
        sets(4.2, "cruise_speed:=0.1"), sets(2.5, "slow_distance:=0.4"), sets(3.2, TWO),
        {"at": 3.0, "e_stop": True}, {"at": 3.5, "goal": [1.5, -0.25]},
        {"at": 5.0, "covers": 1.0}, {"at": 0.0, "box": [5.0, 1.5]}]),
    ("live_parameters", "live_wall", [sets(1.5, "cruise_speed:=fast")]),  # has a setter of its own
    ("live_parameters", "live_pairs", [sets(3.6, "cruise_speed:=0.45")]),  # extends another
    ("three_nodes", "demo_wall", [sets(2.0, "cruise_speed:=0.1", "/shuttle/driver"),
                                  sets(2.0, "max_speed:=0.2", "/shuttle/guard")]),
]  # fmt: skip
WALL = [(2.5, "slow_distance:=0.4", f"refused: {REASON}"), (3.0, "e-stop pressed", ""),
        (3.2, TWO, "accepted"), (4.2, "cruise_speed:=0.1", "accepted")]  # fmt: skip


def test_what_is_saved_drives_again_to_the_same_digest(
    forkserver: ForkServer, tmp_path: Path
) -> None:
    done = []
    for number, (slug, name, deeds) in enumerate(DRIVEN):
        files, folder = find_exercise(slug).files, tmp_path / str(number)
        node, saved = find_exercise(slug).solutions / files[0], folder / f"{name}_by_hand.toml"
        of_page = {"tell": True, "others": files}  # of an exercise's, or of a program's
        more = of_page if number else {"arguments": "--scenario another"}
        order = {"file": str(node), "scenario": name, "deeds": deeds, **more}
        [said] = said_by_page(folder, [order])
        here: Recording = pickle.loads(saved.with_suffix(".pickle").read_bytes())[0]
        submission = drive.unpacked(find_submission(node, files[0], files[1:]), forkserver)
        there = drive.drive_node(submission, drive.scenario_for(str(saved)), forkserver)
        assert here.digest() == there.digest(), saved.read_text("utf-8")
        done.append([(d["at"], d["text"], d["said"]) for d in said["hand"]["done"]])
        if number == 0:
            assert said["hand"]["knobs"][0] == KNOB
            assert said["hand"]["knobs"][1]["values"] == [[0.0, "0.5"], [3.2, "0.6"]]
            assert "/scan" in said["hand"]["hears"]
    wall, own, pairs, shuttle = done
    assert wall == WALL
    assert own[1][2].startswith("refused: Wrong parameter type")
    assert [answer for *_, answer in (pairs[-1], *shuttle)] == ["accepted"] * 3


def test_each_scenario_takes_what_is_done_by_hand() -> None:
    deeds = [sets(2.5, "speed:=0.2", "/a"), sets(1.5, "speed:=0.1", "/b"),
             {"at": 2.0, "goal": [1.5, -0.25]}, {"at": 0.0, "box": [2.0, 1.0]}]  # fmt: skip
    for name in scenario_names():
        own, mine = load_scenario(name), scenario_from_toml(scenario_by_hand(name, deeds), name)
        assert mine.program[-1].arguments == ("/b", "1.5 speed:=0.1")
        assert mine.world.boxes[:-1] == own.world.boxes
        kept = set(own.__struct_fields__) - {"name", "title", "program", "script", "world"}
        assert all(repr(getattr(mine, key)) == repr(getattr(own, key)) for key in kept), name


@pytest.mark.parametrize("name", ["demo_cart_from_the_left", "goal_field_mirrored"])
def test_a_goal_is_sent_where_somebody_clicked_on_a_turned_map(name: str) -> None:
    text = scenario_by_hand(name, [{"at": 2.0, "goal": [1.0, 3.0]}])
    simulation = Simulation(scenario_from_toml(text, "mine"))
    sent = [m for m in simulation.advance(2 * 10**9, []) if m.topic == GOAL_TOPIC]
    goals = views.goals(sent[-1:])
    assert (goals.x[0], goals.y[0]) == pytest.approx((1.0, 3.0), abs=0.001)
