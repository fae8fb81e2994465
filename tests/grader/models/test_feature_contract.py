"""One contract for the five features: one text in the references, and it pastes into skeletons."""

import ast
import math
from array import array
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from sensor_msgs.msg import LaserScan

from grader.course.exercises import ROOT
from grader.models.features import possible_features
from grader.recording import Scan

FUNCTION, CONSTANT = "extract_features", "FRONT_HALF_ANGLE"
CONTROLLER = "ml_velocity/ml_velocity_controller.py"  # where a student writes the function
TRAINING = "ml_velocity/train_velocity_model.py"
NODES = (
    "slow_model/decoupled_controller.py",
    "model_server/detection_server.py",
    "model_formats/policy_controller.py",
    "latency_monitor/profiled_controller.py",
)
REFERENCE = (ROOT / "solutions" / CONTROLLER).read_text("utf-8")


# --- scans -----------------------------------------------------------------------------------


def full_turn(*changes: tuple[slice, float], start: float = -math.pi, low: float = 0.15) -> Scan:
    """Return a scan of 360 beams over a turn from `start` [rad], with some readings changed."""
    ranges = np.linspace(1.0, 5.0, 360, dtype=np.float32)
    for part, reading in changes:
        ranges[part] = reading
    low, step, start = (float(np.float32(x)) for x in (low, math.radians(1.0), start))
    return Scan(0.0, 0.0, start, step, low, 12.0, ranges)


def wide() -> Scan:
    """Return a scan of 1080 beams over ±135°."""
    start, step = (float(np.float32(math.radians(x))) for x in (-135.0, 270.0 / 1079))
    ranges = np.linspace(20.0, 1.0, 1080, dtype=np.float32)
    return Scan(0.0, 0.0, start, step, 0.06, 10.0, ranges)


SEEN = {
    "plain": full_turn(),
    "nan": full_turn((slice(170, 190), math.nan)),
    "minus_infinity": full_turn((slice(240, 360), -math.inf), (slice(180, 181), -math.inf)),
    "too_near_and_too_far": full_turn((slice(100, 110), 0.1), (slice(200, 210), 13.0)),
    "lds_01": full_turn((slice(0, 20), 0.0), start=0.0, low=0.12),
    "wide": wide(),
}
BLIND = {
    "front": full_turn((slice(118, 243), math.nan)),
    "right": full_turn((slice(0, 123), math.nan)),
    "no_beams": Scan(0.0, 0.0, -math.pi, 0.1, 0.15, 12.0, np.empty(0, np.float32)),
}


def fields(scan: Scan) -> dict[str, Any]:
    """Return the scan's fields as a message has them."""
    return {
        "ranges": array("f", scan.ranges.tobytes()),
        "angle_min": scan.angle_min,
        "angle_increment": scan.angle_increment,
        "range_min": scan.range_min,
        "range_max": scan.range_max,
    }


def message(scan: Scan) -> LaserScan:
    last = scan.angle_min + scan.angle_increment * (len(scan.ranges) - 1)
    return LaserScan(angle_max=last, **fields(scan))


# --- programs --------------------------------------------------------------------------------


def definition(source: str, name: str) -> ast.stmt:
    """Return the one function or constant of that name at the top of a program."""
    found = [
        node
        for node in ast.parse(source).body
        if (isinstance(node, ast.FunctionDef) and node.name == name)
        or (isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == name)
    ]
    assert len(found) == 1, f"{len(found)} definitions of {name}"
    return found[0]


def lines_of(node: ast.stmt) -> slice:
    assert node.end_lineno is not None
    return slice(node.lineno - 1, node.end_lineno)


def pasted(student: str, skeleton: Path) -> dict[str, Any]:
    """Return what a skeleton defines with the student's function in the place of its own."""
    text = skeleton.read_text("utf-8")
    lines, theirs = text.splitlines(), student.splitlines()
    lines[lines_of(definition(text, FUNCTION))] = theirs[lines_of(definition(student, FUNCTION))]
    names: dict[str, Any] = {"__name__": "pasted"}
    exec(compile("\n".join(lines), skeleton.name, "exec"), names)
    return names


def right(found: np.ndarray | None, scan: Scan) -> bool:
    """Return whether features are in the form of the contract and right."""
    assert found is not None
    assert found.shape == (1, 5)
    assert found.dtype == np.float32
    return any(np.allclose(found[0], row, rtol=1e-6) for row in possible_features(scan))


def check(extract: Callable[[Any], np.ndarray | None], make: Callable[[Scan], Any]) -> None:
    """Hold a function against the judge's oracle."""
    assert [name for name, scan in SEEN.items() if not right(extract(make(scan)), scan)] == []
    assert [name for name, scan in BLIND.items() if extract(make(scan)) is not None] == []


# --- the tests -------------------------------------------------------------------------------


@pytest.mark.parametrize("path", [CONTROLLER, TRAINING, *NODES])
def test_the_references_have_one_text_which_the_skeletons_promise(path: str) -> None:
    other = (ROOT / "solutions" / path).read_text("utf-8")
    for name in (FUNCTION, CONSTANT):
        assert ast.unparse(definition(other, name)) == ast.unparse(definition(REFERENCE, name))
    theirs = definition((ROOT / "exercises" / path).read_text("utf-8"), FUNCTION)
    ours = definition(REFERENCE, FUNCTION)
    assert isinstance(theirs, ast.FunctionDef)
    assert isinstance(ours, ast.FunctionDef)
    assert ast.get_docstring(theirs) == ast.get_docstring(ours)
    zeros = "np.zeros((1, 5), dtype=np.float32)"  # another exercise's task is none of these
    rest = "return None" if path in (CONTROLLER, TRAINING) else f"return {zeros}"
    assert [ast.unparse(line) for line in theirs.body[1:]] == [rest]


@pytest.mark.parametrize("path", NODES)
def test_a_students_own_function_fits_into_every_node(path: str) -> None:
    check(pasted(REFERENCE, ROOT / "exercises" / path)[FUNCTION], message)


def test_a_students_own_function_fits_into_the_training_script() -> None:
    pytest.importorskip("skl2onnx")
    script = pasted(REFERENCE, ROOT / "exercises" / TRAINING)
    check(
        script[FUNCTION],
        lambda scan: script["LaserScan"](**{**fields(scan), "ranges": scan.ranges.tolist()}),
    )
