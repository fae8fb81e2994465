"""lessons/pitfalls: wrong nodes fail as their pages say, right ones do not, and none passes."""

from pathlib import Path

import numpy as np
import pytest
from pitfall_runs import EVERY, Runs, each_pitfall, each_wrong, long_but_1

from grader.authoring.pitfalls import MADE, NODES, PITFALLS, Pitfall, grade, grade_mutant
from grader.course.exercises import find_exercise
from grader.course.submission import find_submission
from grader.drive import drive_node, print_summary, scenario_for
from rclpy_virtual_time.link.hosts import ForkServer

MOST = 50  # core points for a node that everybody can copy
QUICK = {  # checks that do to show it, where all of them take long
    "obstacle_avoidance": (
        *("clear_zone", "slow_zone", "ignores_behind", "sees_sides", "infinite_readings"),
        *("invalid_readings", "blind"),
    ),
    "ml_velocity": (
        *("front_min", "front_mean", "front_std", "left_min", "right_min", "infinite_readings"),
        *("minus_infinity", "dropped_readings", "blind_sector", "training_runs", "training_data"),
        *("file_names", "model_loads", "model_accuracy", "prediction_time", "onnx_form"),
        *("onnx_agrees", "repeatable"),
    ),
    "goal_seeking": (
        *("silent_until_ready", "control_rate", "turns_short_way", "speed_law", "limits"),
        *("near_goal", "bad_input", "warns"),
    ),
    "slow_model": (
        *("inference_rate", "one_at_a_time", "too_old", "recovery", "features", "clipped"),
        *("no_model", "starts_at_zero"),
    ),
    "safety_supervisor": (
        *("control_rate", "obstacle", "limits", "stale_command", "stale_scan", "bad_command"),
        *("reasons", "levels", "status_text"),
    ),
}


# --- the nodes ------------------------------------------------------------------------------------


@each_wrong
def test_a_wrong_node_goes_wrong_and_lives(runs: Runs, pitfall: Pitfall, node: str) -> None:
    recording = runs.of(pitfall.name, node)
    assert recording.outcome.completed
    assert next(pitfall.moments(recording), None) is not None


@each_pitfall
def test_a_right_node_does_well_in_the_same_scenario(runs: Runs, pitfall: Pitfall) -> None:
    recording = runs.right(pitfall.name)
    assert recording.outcome.completed
    assert list(pitfall.moments(recording)) == []
    assert not recording.truth.contact.any()
    assert np.abs(recording.truth.v).max() > 0.25  # it did drive


def test_drive_takes_twist_stamped_and_says_so(
    forkserver: ForkServer, capsys: pytest.CaptureFixture[str]
) -> None:
    node = find_submission(NODES / "twist_stamped_wrong.py")
    recording = drive_node(node, scenario_for("avoid_wall", duration=3.0), forkserver)
    capsys.readouterr()
    print_summary(recording, file=node.path.name)
    assert np.abs(recording.truth.v).max() > 0.35
    assert "the robot understood" in " ".join(capsys.readouterr().out.split())


# --- what the grader says -------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("exercise", "node"),
    [
        pytest.param(slug, node, marks=long_but_1(slug))
        for slug, node in sorted({(pitfall.exercise, node) for pitfall, node in EVERY})
    ],
)
def test_no_published_node_passes(forkserver: ForkServer, exercise: str, node: str) -> None:
    """What is lost in some checks cannot be won in the others."""
    grading = grade(exercise, NODES / f"{node}.py", forkserver, only=QUICK.get(exercise, ()))
    assert find_exercise(exercise).max_points == 100
    assert 100 - sum(check.max_points - check.points for check in grading.checks) <= MOST


@pytest.mark.long
def test_what_is_not_heard_is_not_called_wrong(forkserver: ForkServer) -> None:
    grading = grade_mutant("obstacle_avoidance/twist_stamped", forkserver)
    assert {check.id for check in grading.checks if check.outcome == "fail"} == {"wiring"}
    assert sum(check.outcome == "skip" for check in grading.checks) == 14


@pytest.mark.parametrize("mutant", [mutant for p in PITFALLS for mutant in p.caught])
def test_every_quoted_check_fails(mutant: str) -> None:
    (quoted,) = (p.caught[mutant] for p in PITFALLS if mutant in p.caught)
    said = (MADE / f"{Path(mutant).name}.grade.txt").read_text("utf-8")
    assert said.count("✗ FAIL") == len(quoted)
    assert said.count("expected  ") == len(quoted)
