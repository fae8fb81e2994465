"""The oracle of model_formats: which speeds are right for a scan, given the scenario's model."""

from __future__ import annotations

import math
from pathlib import PurePath
from typing import Any

import numpy as np

from grader.checks.ml_velocity.contract import Right, max_speed
from grader.models.features import possible_features
from grader.models.files import probe
from grader.recording import Recording, Scan
from sim.scenario import Scenario

MODEL_PATH = "velocity_model.pkl"
LIBRARIES = {".pkl": "sklearn", ".onnx": "onnxruntime", ".pt2": "torch", ".keras": "keras"}


def model_file(scenario: Scenario) -> str:
    """Return the parameter model_path that the node was given."""
    return str(scenario.node.parameters.get("model_path", MODEL_PATH))


def right_speed(recording: Recording, scan: Scan) -> Right:
    """Return the speeds that the contract allows for this scan."""
    model = _model(recording.scenario)
    limit = max_speed(recording.scenario)
    speeds = [_speed(model, row, limit) for row in possible_features(scan)]
    return Right(min(speeds), max(speeds))


def _speed(model: Any, row: np.ndarray, limit: float) -> float:
    """Return what a node commands for features (5,), NaN where a sector is blind [m/s]."""
    if model is None or not np.isfinite(row).all():
        return 0.0
    try:
        said = float(model.predict(row[None, :])[0])
    except RuntimeError:  # what a raising probe raises
        return 0.0
    return min(max(said, 0.0), limit) if math.isfinite(said) else 0.0


def _model(scenario: Scenario) -> Any:
    """Return what the node ought to have loaded, as a probe; None if there is nothing to load."""
    file = model_file(scenario)
    library = LIBRARIES.get(PurePath(file).suffix.lower())
    model = scenario.node.models.get(file)
    if library is None or library in scenario.node.hides or model is None:
        return None
    return None if model.probe == "garbage" else probe(model)
