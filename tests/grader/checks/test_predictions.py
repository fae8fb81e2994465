"""What a node with a model may command: what its model says, and what it was asked."""

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from grader.checks.case import Runs, among, exactly
from grader.checks.commands import Answer
from grader.checks.model_commands import predicts
from grader.checks.predictions import TOLERANCE, max_speed, prediction, predictions, speed_cases
from grader.checks.verdict import CheckFailed
from grader.models.files import probe
from grader.recording import Inference, Scan
from rclpy_virtual_time.link.log import LogLine
from sim.scenario import Model, NodeSpec


def scan(readings: dict[int, float], elsewhere: float = 2.0) -> Scan:
    """360 beams, one a degree from -180° on; these angles [°] read these distances [m]."""
    ranges = [readings.get(angle, elsewhere) for angle in range(-180, 180)]
    return Scan(0.0, 0.0, -math.pi, math.radians(1), 0.12, 3.5, np.array(ranges, np.float32))


EVERYWHERE = scan({})
BLIND = scan({}, elsewhere=math.nan)
AT_THE_EDGE = scan({60: 1.0})  # ahead or left, who knows


@pytest.mark.parametrize(
    ("value", "right"), [(0.3, 0.3), (0.9, 0.5), (-0.2, 0.0), (math.nan, 0.0), (math.inf, 0.0)]
)
def test_what_a_model_predicts_is_clipped(value: float, right: float) -> None:
    model = probe(Model("constant", {"value": value}))
    assert prediction(model, EVERYWHERE, 0.5) == exactly(right)


def test_without_model_or_reading_only_zero_is_right() -> None:
    assert prediction(None, EVERYWHERE, 0.5) == exactly(0.0)
    model = probe(Model("constant", {"value": 0.3}))
    assert prediction(model, BLIND, 0.5) == exactly(0.0)
    raising = probe(Model("raises_near", {"distance": 99.0}))
    assert prediction(raising, EVERYWHERE, 0.5) == exactly(0.0)


def test_a_beam_at_a_sectors_edge_may_count_on_either_side() -> None:
    model = probe(Model("echo", {"feature": 0.0, "scale": 0.1}))
    found = prediction(model, AT_THE_EDGE, 0.5)

    assert found == (pytest.approx((0.1, 0.2)),)
    right = (0.15, 0.20004, 0.2001, 0.0, math.nan)
    assert [among(speed, found, TOLERANCE) for speed in right] == [True, True, False, False, False]


def test_where_a_prediction_may_be_missing_zero_is_right_too() -> None:
    raises_near = probe(Model("raises_near", {"distance": 1.5, "value": 0.2}))
    found = prediction(raises_near, AT_THE_EDGE, 0.5)
    assert [among(speed, found, TOLERANCE) for speed in (0.0, 0.2, 0.1)] == [True, True, False]


def fake(scans: tuple[Scan, ...], **settings: float) -> SimpleNamespace:
    models = {"velocity_model.pkl": Model("slow", dict(settings))}
    node = NodeSpec(parameters={"max_speed": 0.15}, models=models)
    return SimpleNamespace(scenario=SimpleNamespace(node=node), scans=lambda: scans, judged={})


def test_each_scan_has_its_prediction() -> None:
    recording = fake((EVERYWHERE, BLIND, AT_THE_EDGE), seconds=60.0, scale=0.05)
    assert max_speed(recording.scenario) == 0.15
    whole, none, between = predictions(recording)

    assert [among(speed, whole, TOLERANCE) for speed in (0.1, 0.1001, 0.0)] == [True, False, False]
    assert [among(speed, none, TOLERANCE) for speed in (0.0, 0.1)] == [True, False]
    assert [among(speed, between, TOLERANCE) for speed in (0.05, 0.1)] == [True, True]


# --- a node that asks its model

ECHO = Model("echo", {"feature": 0.0, "scale": 0.1})
FRONTS = (1.0, 2.0, 3.0)  # [m] of a scan a second
RIGHT = (0.1, 0.2, 0.3)  # [m/s]


def question(at: float, said: float) -> Inference:
    return Inference("predict", "velocity_model.pkl", int(at * 1e9), int(at * 1e9), 0, (said,))


def recorded(
    monkeypatch: pytest.MonkeyPatch,
    speeds: tuple[float, ...],
    asked: tuple[float, ...] = RIGHT,
    **node: Any,
) -> Any:
    """Return the run of a node that commanded these speeds and asked its model."""
    scans = [replace(scan({}, elsewhere=front), t=float(i)) for i, front in enumerate(FRONTS)]
    found = [
        Answer(each, "", (), count=1, twist={"linear.x": speed})
        for each, speed in zip(scans, speeds, strict=True)
    ]
    monkeypatch.setattr("grader.checks.predictions.answers", lambda _: found)
    node = {"parameters": {}, "models": {"velocity_model.pkl": ECHO}, **node}
    return SimpleNamespace(
        name="run",
        scenario=SimpleNamespace(node=NodeSpec(**node), bench_scans=found),
        log=[],
        slack=0.0,
        duration_s=3.0,
        inferences=[question(i + 0.01, said) for i, said in enumerate(asked)],
        outcome=SimpleNamespace(completed=True),
        judged={},
        times=lambda _: np.arange(3.0),
    )


def judge(run: Any, help: str = "") -> None:
    predicts(Runs([run], lambda run: speed_cases(run, ECHO)), help=help)


def wrong(run: Any) -> list[str]:
    return [case.wrong(1e-3) for case in speed_cases(run, ECHO)]


def test_what_the_model_says_is_right(monkeypatch: pytest.MonkeyPatch) -> None:
    assert wrong(recorded(monkeypatch, RIGHT)) == ["", "", ""]
    assert wrong(recorded(monkeypatch, (0.1, 0.2, 0.25))) == ["", "", "linear.x"]
    assert wrong(recorded(monkeypatch, RIGHT, ())) == ["predict"] * 3  # computed without it
    assert wrong(recorded(monkeypatch, RIGHT, (0.1, 0.3, 0.3))) == ["", "predict", ""]
    assert wrong(recorded(monkeypatch, (0.0,) * 3, (), parameters={"max_speed": 0.0})) == [""] * 3
    judge(recorded(monkeypatch, RIGHT))


@pytest.mark.parametrize(
    ("time", "quoted"), [(-0.5, True), (0.9, False), (1.0, True), (1.9, True), (2.1, False)]
)
def test_the_log_is_quoted_where_it_is_about_the_scan(
    monkeypatch: pytest.MonkeyPatch, time: float, quoted: bool
) -> None:
    run = recorded(monkeypatch, (0.1, 0.0, 0.3))
    run.log = [LogLine(int(time * 1e9), "error", "not finite")]

    with pytest.raises(CheckFailed) as caught:
        judge(run, "Look.")

    assert caught.value.help == ("The node's log says: not finite" if quoted else "Look.")


def test_a_rounded_prediction_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(CheckFailed, match="wrong linear") as caught:
        judge(recorded(monkeypatch, (0.1, 0.204, 0.3)))
    assert "rounded" in caught.value.help
    assert caught.value.actual == "linear.x = 0.204 m/s"
