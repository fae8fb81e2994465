"""What counts as a mishap, and how it is put, with nodes that are functions."""

import pytest
from driven import careful, drive_by, reckless, timid

from grader.course.exercises import find_exercise
from grader.drive.mishaps import mishap_of
from grader.drive.search.words import sentence, title
from grader.exercises import driving_contract_of as contract_of
from sim.scenario_files import scenario_from_toml

ROOM = "walls = [{ points = [[-3, -3], [4, -3], [4, 3], [-3, 3]], closed = true }]"


def world(text, keys=""):
    return scenario_from_toml(f'title = "x"\nduration = 6\n{keys}\n[world]\n{text}', "x")


def judged(policy, scenario, exercise):
    recording = drive_by(policy, scenario)
    mishap = mishap_of(recording, contract_of(find_exercise(exercise)))
    return None if mishap is None else (mishap.kind, sentence(recording, mishap))


# --- touches -------------------------------------------------------------------------------------


def test_a_box_aside_is_named_with_the_beams_that_see_it():
    def by_cone(scan):
        ahead = abs(scan.angles) <= 3 * 3.1416 / 180
        return 0.5 if scan.ranges[ahead].min() > 0.6 else 0.0

    scenario = world("boxes = [{ center = [1.0, 0.25], size = [0.2, 0.2] }]")
    assert judged(by_cone, scenario, "1") == (
        "touches",
        "A box of 0.2 m at 1.0 m, 14° to the left, seen only by beams beyond 11° to the left in "
        "the last second: the robot touches it at 2.0 s.",
    )


def test_the_touched_thing_is_the_one_that_is_named():
    boxes = "[{ center = [1, 2], size = [0.3, 0.3] }, { center = [1, 0], size = [0.9, 0.1] }]"
    kind, text = judged(reckless, world(f"boxes = {boxes}"), "1")
    assert kind == "touches"
    assert text.startswith("A wall of 0.9 m at 1.0 m, straight ahead (and 1 more): the robot")


def test_a_right_node_has_no_mishap():
    assert judged(careful, world(ROOM), "1") is None


# --- stands, and never arrives -------------------------------------------------------------------


def test_a_node_that_stands_before_an_obstacle_is_right():
    scenario = world("boxes = [{ center = [0.6, 0], size = [0.3, 0.3] }]")
    assert judged(timid, scenario, "1") is None


def test_a_node_that_stands_where_nothing_is_ahead_is_wrong():
    scenario = world("boxes = [{ center = [-0.6, 0], size = [0.3, 0.3] }]")
    kind, text = judged(timid, scenario, "1")
    assert kind == "stands"
    assert text.startswith("A box of 0.3 m at 0.6 m, straight behind: the robot stands for ever")


GOAL = "script = [{ at = 0.5, goal = [-1, 0, 0] }]"


def test_a_node_that_does_not_move_to_its_goal_stands():
    kind, text = judged(timid, world("", GOAL), "3")
    assert (kind, text) == (
        "stands",
        "A goal at 1.0 m, straight behind: the robot stands for ever, 1.0 m from its goal, from "
        "0.0 s on.",
    )


def test_a_node_that_drives_away_from_its_goal_never_arrives():
    kind, text = judged(lambda scan: 0.3, world("", GOAL), "3")
    assert kind == "lost"
    assert text.endswith("the robot never comes nearer to its goal than 1.1 m in 6 s.")
    assert judged(lambda scan: 0.3, world("", GOAL.replace("-1", "1")), "3") is None


# --- limits --------------------------------------------------------------------------------------

ASKED = "raw = [{ from = 0.1, to = 6, linear_x = 0.5, rate = 10 }]"
E_STOP = f"{ASKED}\nscript = [{{ at = 2, e_stop = true }}, {{ at = 4, e_stop = false }}]"


def ramping(until, after):
    """Ramp up, and from some time to another stand."""
    speed = 0.0

    def policy(scan):
        nonlocal speed
        speed = 0.0 if until <= scan.t < after else min(0.3, speed + 0.04)
        return speed

    return policy


@pytest.mark.parametrize("span", [(9, 9), (2.0, 3.0), (3.0, 4.0)])
def test_an_emergency_stop_that_is_not(span):
    kind, text = judged(ramping(*span), world("", E_STOP), "7")
    assert kind == "breaks"
    assert text.startswith("With a model that asks for 0.5 m/s and with an emergency stop at 2 s:")
    assert "the node drives on in an emergency stop at " in text
    assert judged(ramping(2.0, 4.0), world("", E_STOP), "7") is None


def test_a_rise_that_the_motors_do_not_make():
    kind, text = judged(lambda scan: 0.3, world("", ASKED), "7")
    assert kind == "breaks"
    assert "speeds up from 0.00 to 0.30 m/s at once" in text


def test_a_node_that_stands_although_it_is_asked_to_drive():
    kind, _ = judged(timid, world("", ASKED), "7")
    assert kind == "stands"
    assert judged(timid, world(""), "7") is None


def test_faults_are_named():
    faults = "faults = { scan_latency = 0.1, nan_speckle = 0.05, blackout = [[5.0, 9.0]] }"
    keys = f"robot = {{ start = [2, 0, 0] }}\n{faults}"
    _, text = judged(reckless, world(ROOM, keys), "1")
    assert text.startswith(
        "The wall of a room, with 5% of the readings NaN and with sensors 100 ms late and without "
        "scans from 5 to 9 s: the robot touches it at "
    )


def test_titles():
    assert title(world("")) == "An empty world"
    assert title(world(ROOM)) == "A room"
    assert title(world("", GOAL)) == "A goal at 1.0 m, straight behind"
    box = "boxes = [{ center = [0, -1], size = [0.2, 0.2] }]"
    assert title(world(box)) == "A box of 0.2 m at 1.0 m, 90° to the right"
