"""The oracle of ml_velocity: which speeds are right for a scan, given the model of the scenario."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from grader.models.features import possible_features
from grader.models.files import probe
from grader.recording import Recording, Scan
from sim.scenario import Scenario

MODEL_PATH = "velocity_model.pkl"
MAX_SPEED = 0.5  # [m/s]


@dataclass(frozen=True)
class Right:
    """The speeds that are right for a scan: an interval, because angles split hairs."""

    low: float  # [m/s]
    high: float  # [m/s]

    def __str__(self) -> str:
        """Return the middle with as many digits as it has."""
        return f"{(self.low + self.high) / 2:.4f}".rstrip("0").ljust(4, "0")


def max_speed(scenario: Scenario) -> float:
    """Return the parameter max_speed that the node was given [m/s]."""
    return float(scenario.node.parameters.get("max_speed", MAX_SPEED))


def right_speed(recording: Recording, scan: Scan) -> Right:
    """Return the speeds that the contract allows for this scan."""
    scenario = recording.scenario
    model = _model(scenario)
    limit = max_speed(scenario)
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
    """Return the probe that the node ought to have loaded; None if there is none to load."""
    path = str(scenario.node.parameters.get("model_path", MODEL_PATH))
    model = scenario.node.models.get(path)
    return None if model is None or model.probe in ("garbage", "foreign") else probe(model)
