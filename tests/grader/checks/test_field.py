"""The field suite makes checks like any other, of every exercise's whole contract."""

import importlib
from typing import Any

import pytest
from node_runs import RunNode, short

from grader.checks.case import Runs
from grader.checks.field import BY_ANGLE, FieldSuite
from grader.checks.verdict import CheckFailed, fail
from grader.course.exercises import all_exercises
from grader.recording import Recording
from sim.scenario_files import load_scenario

EXERCISES = [exercise.slug for exercise in all_exercises()]


def mark(check: Any) -> dict[str, Any]:
    (found,) = check.pytestmark
    return dict(found.kwargs)


def test_a_check_says_what_it_is() -> None:
    field = FieldSuite(lambda runs, help: None, needs=("server_wiring",))
    check = field.lds01("one", "two", requires=("onnx",))

    assert check.__doc__ == (
        "Works with an LDS-01: beams from 0 to 2π, 0.0 for no return, 3.5 m, 5 Hz."
    )
    assert mark(check) == {
        "field": True,
        "asks": "decision",
        "points": 0,
        "task": 0,
        "hint": "",
        "scenarios": ("one", "two"),
        "needs": ("server_wiring",),
        "requires": ("onnx",),
    }
    odometry = field.best_effort("three", sensor="an odometry")
    assert (odometry.__doc__ or "").startswith("Hears an odometry driver")
    assert mark(check)["scenarios"] == ("one", "two")


def test_each_recording_has_to_keep_the_contract(run_node: RunNode) -> None:
    judged: list[tuple[Recording, str]] = []

    def contract(runs: Runs, help: str) -> None:
        judged.append((runs[0], help))
        if len(judged) == 2:
            fail("no", help=help)

    check = FieldSuite(contract).wide_lidar("one", "two")
    recording = run_node("rclpy.init(); rclpy.spin(Echo())", short(0.5))
    runs = Runs([recording], lambda recording: (), "obstacle_avoidance")
    check(runs)
    with pytest.raises(CheckFailed) as caught:
        check(runs)
    assert judged == [(recording, BY_ANGLE)] * 2
    assert caught.value.help == BY_ANGLE


def test_a_node_that_is_not_wired_fails_before_its_contract(run_node: RunNode) -> None:
    def contract(runs: Runs, help: str) -> None:
        raise AssertionError("not reached")

    deaf = run_node("rclpy.init(); rclpy.spin(Node('deaf'))", short(0.5))
    with pytest.raises(CheckFailed, match="there is no"):
        FieldSuite(contract).speckle("one")(
            Runs([deaf], lambda recording: (), "obstacle_avoidance")
        )


@pytest.mark.parametrize("slug", EXERCISES)
def test_every_exercise_hears_best_effort_and_stands_two_more_surprises(slug: str) -> None:
    module = importlib.import_module(f"grader.exercises.{slug}.test_field")
    checks = {name: check for name, check in vars(module).items() if name.startswith("test_")}

    assert "test_field_best_effort" in checks
    assert len(checks) >= 3
    assert all(name.startswith("test_field_") for name in checks)
    for check in checks.values():
        assert mark(check)["field"] is True
        assert not mark(check).get("points")
        for name in mark(check)["scenarios"]:
            assert load_scenario(name).name == name
