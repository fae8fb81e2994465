"""The oracle of ml_velocity: which speeds are right for a scan, given the model of the scenario."""

from __future__ import annotations

from typing import Any

from grader.checks.braking import braking, model_says_go
from grader.checks.contract import Contract, Survived
from grader.checks.predictions import MODEL, SpeedInterval, max_speed, right_speeds
from grader.models.features import FRONT_EDGE
from grader.models.files import is_kept, probe
from grader.recording import Recording, Scan
from sim.scenario import Scenario

# what a check requires where the judge runs: to make a trained model, to run a training
FOREST = ("sklearn",)
TRAINING = ("sklearn", "skl2onnx", "onnxruntime")

LEAST_WAY = 0.6  # [m] driven in each world, however the seed turns the robot

CONTRACT = Contract(
    free=model_says_go,
    nodes=(braking("echo"),),
    delayed_in=("ml_drive_wall", "ml_drive_cart", "ml_drive_store"),
    survives=Survived(sensors=125, commands=125),
)


def right_speed(recording: Recording, scan: Scan, front: float = FRONT_EDGE) -> SpeedInterval:
    """Return the speeds that the contract allows for this scan: its front ends at ±`front` [°]."""
    scenario = recording.scenario
    return right_speeds(_model(scenario), scan, max_speed(scenario), front)


def is_predicted(recording: Recording) -> bool:
    """Tell whether there is a model to ask, and the judge keeps it."""
    name = _path(recording.scenario)
    model = recording.scenario.node.models.get(name)
    return model is not None and is_kept(name, model)


def _path(scenario: Scenario) -> str:
    return str(scenario.node.parameters.get("model_path", MODEL))


def _model(scenario: Scenario) -> Any:
    """Return the probe that the node ought to have loaded; None if there is none to load."""
    model = scenario.node.models.get(_path(scenario))
    return None if model is None or model.probe in ("garbage", "empty", "foreign") else probe(model)
