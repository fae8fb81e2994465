"""The search for counter-examples, with nodes that are functions; a real one is at the end."""

import os
import re
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import msgspec
import pytest
from click.testing import CliRunner
from driven import careful, drive_by, reckless, timid
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from grader.authoring.mutants import find_mutant
from grader.cli import cli
from grader.course.exercises import all_exercises, exercise_for, find_exercise
from grader.drive import node
from grader.drive.search import arena_of, search
from grader.drive.search.fair import is_fair
from grader.drive.search.finder import cut
from grader.drive.search.toml import scenario_to_toml
from grader.errors import InputError
from grader.exercises import contract_of
from grader.recording import Outcome
from sim.scenario import Scenario
from sim.scenario_files import load_scenario, scenario_from_toml

ROOT = Path(__file__).resolve().parents[3]
SEARCHED = [each.number for each in all_exercises() if contract_of(each).drives]
TRIES = int(os.environ.get("COURSE_TRIES", "15"))  # in each reference
SETTINGS = settings(
    derandomize=True, deadline=None, max_examples=40, phases=[Phase.generate],
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.filter_too_much],
)  # fmt: skip
FIRST = arena_of(find_exercise("1"))


def by(policy):
    return lambda scenario: drive_by(policy, scenario)


# --- what is found -------------------------------------------------------------------------------


def test_a_node_that_never_brakes_touches_a_small_box_and_nothing_else_is_in_the_world():
    found = search(FIRST, by(reckless), tries=60).found
    assert found is not None
    assert found.mishap.kind == "touches"
    world = found.scenario.world
    assert len(world.boxes) + len(world.walls) == 1
    assert found.scenario.faults == Scenario(title="", world=world).faults
    assert found.recording.truth.contact.any()
    assert len(found.toml.splitlines()) <= 12
    assert found.sentence.endswith(f"the robot touches it at {found.mishap.at:.1f} s.")


def test_a_node_that_stands_for_ever_is_found_in_the_simplest_world():
    result = search(FIRST, by(timid), tries=30)
    assert result.found is not None
    assert result.found.mishap.kind == "stands"
    assert not result.found.scenario.world.boxes
    assert result.found.sentence == (
        "In an empty world: the robot stands for ever though its way is free, from 0.0 s on."
    )
    assert result.found.recording.scenario == result.found.scenario


def test_a_careful_node_is_not_found():
    result = search(FIRST, by(careful), tries=40)
    assert (result.found, result.tries) == (None, 40)


@pytest.mark.parametrize(
    ("speed", "said"),
    [
        (0.6, "In an empty world: the node asks for 0.60 m/s at 0.0 s."),
        (float("nan"), "In an empty world: the node sends a command that is not finite at 0.0 s."),
    ],
)
def test_a_command_that_no_right_node_sends_is_found(speed, said):
    found = search(FIRST, by(lambda scan: speed), tries=5).found
    assert found is not None
    assert (found.mishap.kind, found.sentence) == ("breaks", said)


def test_a_node_that_dies_is_found():
    died = Outcome("exception", "ZeroDivisionError: division by zero", 0.3)
    found = search(FIRST, lambda scenario: drive_by(careful, scenario, died), tries=5).found
    assert found is not None
    assert found.mishap.kind == "dies"
    assert "the node dies: ZeroDivisionError" in found.sentence
    assert found.scenario.duration == 2.0


def test_a_touch_counts_more_than_standing_although_it_is_found_later():
    def stands_where_it_sees_nothing(scan):
        return 0.0 if scan.ranges.min() > 2.5 else 0.5

    found = search(FIRST, by(stands_where_it_sees_nothing), tries=5).found
    assert found is not None
    assert found.mishap.kind == "stands"  # in the simplest world of all: nothing is simpler

    def stands_in_rooms(scan):
        return 0.0 if scan.ranges.max() < 11.0 else 0.5

    found = search(FIRST, by(stands_in_rooms), tries=80).found
    assert found is not None
    assert found.mishap.kind == "touches"


# --- by seed, and by whom it ends ----------------------------------------------------------------


def test_the_same_seed_and_number_of_tries_give_the_same_world():
    first, again = (search(FIRST, by(reckless), seed=3, tries=25).found for _ in range(2))
    assert first is not None and again is not None
    assert first.toml == again.toml
    assert first.recording.digest() == again.recording.digest()


def test_interrupted_it_keeps_the_smallest_so_far():
    drives = []

    def drive(scenario):
        drives.append(scenario)
        if len(drives) == 7:
            raise KeyboardInterrupt
        return drive_by(reckless, scenario)

    result = search(FIRST, drive, tries=200)
    assert result.interrupted
    assert result.tries == 6
    assert result.found is not None


def test_trouble_of_the_grader_ends_the_search_as_it_is():
    def drive(scenario):
        raise InputError("no such lidar")

    with pytest.raises(InputError, match="no such lidar"):
        search(FIRST, drive, tries=5)


def test_a_node_that_needs_real_time_is_refused():
    odd = Outcome("real_time", "it needs real time", 0.0)
    with pytest.raises(InputError, match="can't be looked at: it needs real time"):
        search(FIRST, lambda scenario: drive_by(careful, scenario, odd), tries=5)


def test_no_time_means_no_tries():
    assert search(FIRST, by(reckless), seconds=1e-9).tries == 0


# --- the worlds ----------------------------------------------------------------------------------


@pytest.mark.parametrize("number", SEARCHED)
def test_every_world_is_fair_and_its_file_says_all_of_it(number):
    @SETTINGS
    @given(arena_of(find_exercise(str(number)), field=True).worlds)
    def check(scenario):
        assert is_fair(scenario)
        text = scenario_to_toml(scenario)
        assert repr(scenario_from_toml(text, "x")) == repr(scenario)  # NaN is not equal to itself

    @SETTINGS
    @given(arena_of(find_exercise(str(number))).worlds)
    def check_without_the_badge(scenario):
        assert (scenario.lidar.profile, scenario.odometry.rate) == ("default", 20.0)
        assert (scenario.faults.scan_loss, scenario.faults.odom_loss) == (0.0, 0.0)
        assert scenario.qos.sensors == "reliable"

    check()
    check_without_the_badge()


def test_a_box_at_the_start_is_not_fair():
    text = 'title = "x"\n[world]\nboxes = [{ center = [0.5, 0], size = [0.2, 0.2] }]'
    scenario = scenario_from_toml(text, "x")
    assert not is_fair(scenario)


@settings(derandomize=True, max_examples=50)
@given(st.text())
def test_any_title_comes_back_from_a_file(text):
    scenario = Scenario(title=text, world=load_scenario("demo_wall").world)
    if "\x00" not in text and text.isprintable():
        assert scenario_from_toml(scenario_to_toml(scenario), "x") == scenario


@pytest.mark.parametrize("name", ["safe_drive", "slow_leader", "goal_changes", "ml_drive_store"])
def test_scenarios_of_the_course_come_back_from_a_file(name):
    scenario = msgspec.structs.replace(load_scenario(name), name="")
    assert scenario_from_toml(scenario_to_toml(scenario), "x") == scenario


def test_what_is_cut_off_is_not_in_the_file():
    scenario = cut(load_scenario("safe_drive"), 4)
    assert scenario.duration == 4.0
    assert [(stream.begin, stream.end) for stream in scenario.raw] == [(0.33, 4.0)]


# --- whose contract ------------------------------------------------------------------------------


def test_the_files_name_tells_the_exercise():
    assert exercise_for(None, "trend_agent.py").number == 4
    assert exercise_for("3", "trend_agent.py").number == 3
    with pytest.raises(InputError, match=r"my_agent\.py: its name is that of no exercise's file"):
        exercise_for(None, "my_agent.py")


def test_exercises_that_do_not_drive_are_refused():
    with pytest.raises(InputError, match="exercise 6: its nodes do not drive by themselves"):
        arena_of(find_exercise("6"))


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["6", "my_agent.py"], "exercise 6: its nodes do not drive"),
        (["--exercise", "6", "my_agent.py"], "exercise 6: its nodes do not drive"),
        (["6", "my_agent.py", "--exercise", "1"], "expected one exercise, got 6, 1"),
        (["1", "6", "my_agent.py"], "expected one exercise, got 1, 6"),
    ],
)
def test_the_exercise_may_stand_before_the_file_as_for_a_grading(words, said):
    done = CliRunner().invoke(cli, ["search", *words], standalone_mode=False)
    assert said in str(done.exception)


# --- for real ------------------------------------------------------------------------------------


def run(*words):
    done = CliRunner().invoke(cli, ["search", *map(str, words)], standalone_mode=False)
    return done, done.stdout


@pytest.mark.long
def test_a_wrong_node_is_found_and_the_file_shows_it_again(tmp_path):
    node = tmp_path / "my_agent.py"
    mutant = find_mutant(find_exercise("1"), "front_is_index_zero")
    node.write_text(mutant.text, "utf-8")
    said = []
    for name in ("one", "two"):
        out = tmp_path / f"{name}.toml"
        done, text = run(
            node, "--exercise", 1, "--tries", 40, "--out", out, "--report", tmp_path / "r.html"
        )
        assert done.exception is None and done.return_value == 1, done.output
        assert "the robot touches it" in text
        said.append(out.read_text("utf-8"))
    assert said[0] == said[1]
    (opens_at,) = re.findall(r'"opens_at": ?([\d.]+)', (tmp_path / "r.html").read_text("utf-8"))
    assert float(opens_at) > 0
    again = subprocess.run(
        [sys.executable, "-m", "grader.cli", "drive", node, "--scenario", tmp_path / "one.toml"],
        capture_output=True, text=True, check=False, cwd=ROOT,
    )  # fmt: skip
    assert "TOUCHED an obstacle" in again.stdout, again.stderr


@pytest.mark.long
@pytest.mark.parametrize("number", SEARCHED if "COURSE_TRIES" in os.environ else (1, 4))
def test_in_a_right_node_nothing_is_found(number):
    exercise = find_exercise(str(number))
    done, text = run(exercise.solutions / exercise.files[0], "--tries", TRIES)
    assert done.return_value == 0, done.output
    assert text.startswith(f"Nothing found in {TRIES} worlds (exercise {number}, seed 0).")


# --- a busy machine ------------------------------------------------------------------------------


@pytest.mark.parametrize("second", ["completed", "hung"])
def test_a_node_that_seems_to_hang_gets_a_second_look(
    monkeypatch: pytest.MonkeyPatch, second: str
) -> None:
    ends, limits_given = ["hung", second], []

    def drive_node(*_: Any, limits: Any, **__: Any) -> Any:
        limits_given.append(limits)
        return SimpleNamespace(outcome=Outcome(ends[len(limits_given) - 1], ""))

    monkeypatch.setattr(node, "drive_node", drive_node)
    nothing: Any = None
    recording = node.drive_in(nothing, load_scenario("demo_wall"), nothing)

    assert recording.outcome.kind == second
    assert [limits.total for limits in limits_given] == [20.0, 60.0]
