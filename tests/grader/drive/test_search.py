"""The search for counter-examples, with nodes that are functions; a real one is at the end."""

import os
import re
from random import Random
from types import SimpleNamespace

import msgspec
import numpy as np
import pytest
from click.testing import CliRunner
from driven import careful, drive_by, reckless

from grader.claims.mutants import find_mutant
from grader.cli import cli
from grader.course.exercises import all_exercises, exercise_for, find_exercise
from grader.drive import node
from grader.drive.as_toml import scenario_to_toml
from grader.drive.search import arena_of, search
from grader.drive.search.fair import is_fair
from grader.drive.search.finder import cut
from grader.drive.search.worlds import Draw
from grader.errors import InputError
from grader.exercises import contract_of
from grader.recording import Outcome
from sim.scenario import Faults
from sim.scenario_files import load_scenario, scenario_from_toml
from sim.world import Box, World

SEARCHED = [each.number for each in all_exercises() if contract_of(each).drives]
TRIES = int(os.environ.get("COURSE_TRIES", "15"))  # in each reference
FIRST = arena_of(find_exercise("1"))


def by(policy, driven=None):
    """Return what drives by a policy, and notes the worlds."""
    notes = [] if driven is None else driven
    return lambda scenario: notes.append(scenario) or drive_by(policy, scenario)


def worlds(arena, count=60):
    chance = Random(1)
    return [arena.world(Draw(chance=chance)) for _ in range(count)]


# --- what is found -------------------------------------------------------------------------------

EMPTY = "In an empty world: the "
DIED = Outcome("exception", "ZeroDivisionError: division by zero", 0.3)


@pytest.mark.parametrize(
    ("speed", "outcome", "kind", "said"),
    [
        (0.0, None, "stands", "robot stands for ever though its way is free, from 0.0 s on."),
        (0.6, None, "breaks", "node asks for 0.60 m/s at 0.0 s."),
        (np.nan, None, "breaks", "node sends a command that is not finite at 0.0 s."),
        (0.0, DIED, "dies", "node dies: ZeroDivisionError: division by zero at 0.3 s."),
    ],
)
def test_what_fails_in_the_simplest_world_is_found_at_once(speed, outcome, kind, said):
    result = search(FIRST, lambda world: drive_by(lambda scan: speed, world, outcome), tries=50)
    found = result.found
    assert (result.tries, found.mishap.kind, found.sentence) == (1, kind, EMPTY + said)
    assert found.scenario.duration == (8.0 if kind == "stands" else 2.0)
    assert found.recording.scenario == found.scenario


def test_a_careful_node_is_not_found():
    result = search(FIRST, by(careful), tries=40)
    assert (result.found, result.tries) == (None, 40)


def test_a_touch_counts_more_than_standing_although_it_is_found_later():
    def stands_in_rooms(scan):
        return 0.0 if scan.ranges.max() < 11.0 else 0.5

    said = []
    found = search(
        FIRST, by(stands_in_rooms), seed=2, tries=80, on_try=lambda _, so_far: said.append(so_far)
    ).found
    assert "stands for ever" in next(so_far for so_far in said if "now looking" in so_far)
    assert found.mishap.kind == "touches"


# --- and made smaller ----------------------------------------------------------------------------


def test_a_node_that_never_brakes_touches_a_small_box_and_nothing_else_is_in_the_world():
    driven = []
    result = search(FIRST, by(reckless, driven), tries=100)
    found, (*tried, shown) = result.found, driven
    assert found.mishap.kind == "touches" and found.recording.truth.contact.any()
    assert found.scenario.world == World(boxes=(Box(center=(0.6, 0.0), size=(0.1, 0.1)),))
    assert found.scenario.faults == Faults()
    assert found.scenario.title == "A box of 0.1 m at 0.6 m, straight ahead"
    touched = f"the robot touches it at {found.mishap.at:.1f} s."
    assert found.sentence == f"{found.scenario.title}: {touched}"
    assert len(found.toml.splitlines()) < 10
    assert shown == found.scenario and result.tries == len(tried) < 40
    assert len(set(map(scenario_to_toml, tried))) == len(tried)  # in none it is driven twice
    assert all(map(is_fair, tried)) and not all(map(is_fair, worlds(FIRST)))


def test_what_the_mishap_needs_stays_and_the_rest_goes_back_to_its_default():
    def reckless_where_nan_comes(scenario):
        return drive_by(reckless if scenario.faults.nan_speckle else careful, scenario)

    found = search(FIRST, reckless_where_nan_comes, tries=100).found
    assert found.scenario.faults == Faults(nan_speckle=0.02)
    assert found.scenario.world == World(boxes=(Box(center=(0.6, 0.0), size=(0.1, 0.1)),))


def test_a_smaller_world_with_another_mishap_does_not_count():
    def dies_of_a_single_box(scenario):
        died = DIED if len(scenario.world.boxes) == 1 else None
        return drive_by(reckless, scenario, died)

    found = search(FIRST, dies_of_a_single_box, seed=0, tries=100).found
    assert found.mishap.kind == "touches"
    assert len(found.scenario.world.boxes) == 2


def test_two_things_that_need_each_other_go_together():
    rooms_and_noise = []

    def reckless_with_both_or_none(scenario):
        room, noise = bool(scenario.world.walls), scenario.faults.range_noise > 0
        rooms_and_noise.append((room, noise))
        return drive_by(reckless if room == noise else careful, scenario)

    search(FIRST, reckless_with_both_or_none, tries=100)
    failed = [each for each in rooms_and_noise[1:] if each[0] == each[1]]
    assert (failed[0], failed[-1]) == ((True, True), (False, False))


# --- by seed, and by whom it ends ----------------------------------------------------------------


def test_the_same_seed_and_number_of_tries_give_the_same_world():
    first, again = (search(FIRST, by(reckless), seed=3, tries=8).found for _ in range(2))
    assert first.toml == again.toml
    assert first.recording.digest() == again.recording.digest()
    driven = [[], []]
    for seed, worlds_of in enumerate(driven):
        search(FIRST, by(careful, worlds_of), seed=seed, tries=5)
    assert driven[0][0] == driven[1][0] and driven[0][1:] != driven[1][1:]


def test_interrupted_it_keeps_the_smallest_so_far():
    driven = []

    def drive(scenario):
        if len(driven) == 7:
            raise KeyboardInterrupt
        return by(reckless, driven)(scenario)

    result = search(FIRST, drive, tries=200)
    assert (result.interrupted, result.tries) == (True, 7)
    assert result.found is not None
    assert "7 worlds (exercise 1, seed 0, interrupted)" in result.account(exercise=1, seed=0)


def test_a_node_that_needs_real_time_is_refused():
    odd = Outcome("real_time", "it needs real time", 0.0)
    with pytest.raises(InputError, match="can't be looked at: it needs real time"):
        search(FIRST, lambda scenario: drive_by(careful, scenario, odd), tries=5)


def test_no_time_means_no_tries():
    assert search(FIRST, by(reckless), minutes=1e-9).tries == 0


# --- the worlds ----------------------------------------------------------------------------------


@pytest.mark.parametrize("number", SEARCHED)
def test_a_file_says_all_of_a_world_and_only_the_badge_asks_for_other_sensors(number):
    def beyond(scenario):
        faults, sensors = scenario.faults, (scenario.lidar.profile, scenario.odometry.rate)
        lost = faults.scan_loss or faults.odom_loss
        return lost or sensors != ("default", 20.0) or scenario.qos.sensors != "reliable"

    exercise = find_exercise(str(number))
    field = worlds(arena_of(exercise, field=True))
    assert any(map(beyond, field)) and not any(map(beyond, worlds(arena_of(exercise))))
    for scenario in field:
        again = scenario_from_toml(scenario_to_toml(scenario), "x")
        assert repr(again) == repr(scenario)  # NaN is not equal to itself


def test_any_numbers_make_a_world_and_zeros_the_simplest():
    draw = Draw((99,) * 100)
    most = FIRST.world(draw)
    assert len(most.world.boxes) == 3 and FIRST.world(Draw(draw.taken)) == most
    assert FIRST.world(Draw((0,) * 100)) == FIRST.world(Draw())
    assert FIRST.world(Draw()).world == World()


def test_a_box_at_the_start_is_not_fair():
    text = 'title = "x"\n[world]\nboxes = [{ center = [0.5, 0], size = [0.2, 0.2] }]'
    assert not is_fair(scenario_from_toml(text, "x"))


@pytest.mark.parametrize("name", ["safe_drive", "slow_leader", "goal_changes", "ml_drive_store"])
def test_scenarios_of_the_course_come_back_from_a_file(name):
    scenario = msgspec.structs.replace(load_scenario(name), name="", title='5°, "left"\'s')
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
    done = CliRunner().invoke(cli, list(map(str, words)), standalone_mode=False)
    return done, done.stdout


@pytest.mark.long
def test_a_wrong_node_is_found_and_the_file_shows_it_again(tmp_path):
    node, report = tmp_path / "my_agent.py", tmp_path / "r.html"
    node.write_text(find_mutant(find_exercise("1"), "front_is_index_zero").text, "utf-8")
    outs = tmp_path / "one.toml", tmp_path / "two.toml"
    for out in outs:
        words = (node, "--exercise", 1, "--tries", 40, "--out", out, "--report", report)
        done, text = run("search", *words)
        assert done.return_value == 1 and "the robot touches it" in text, done.output
    assert outs[0].read_text("utf-8") == outs[1].read_text("utf-8")
    (opens_at,) = re.findall(r'"opens_at": ?([\d.]+)', report.read_text("utf-8"))
    assert float(opens_at) > 0
    assert "TOUCHED an obstacle" in run("drive", node, "--scenario", outs[0])[1]


@pytest.mark.long
@pytest.mark.parametrize("number", SEARCHED if "COURSE_TRIES" in os.environ else (1, 4))
def test_in_a_right_node_nothing_is_found(number):
    exercise = find_exercise(str(number))
    done, text = run("search", exercise.solutions / exercise.files[0], "--tries", TRIES)
    assert done.return_value == 0, done.output
    assert text.startswith(f"Nothing found in {TRIES} worlds (exercise {number}, seed 0).")


# --- a busy machine ------------------------------------------------------------------------------


@pytest.mark.parametrize("second", ["completed", "hung"])
def test_a_node_that_seems_to_hang_gets_a_second_look(monkeypatch, second):
    ends, totals = iter(["hung", second]), []

    def drive_node(*_, limits, **__):
        totals.append(limits.total)
        return SimpleNamespace(outcome=Outcome(next(ends), ""))

    monkeypatch.setattr(node, "drive_node", drive_node)
    assert node.drive_in(None, load_scenario("demo_wall"), None).outcome.kind == second
    assert totals == [20.0, 60.0]
