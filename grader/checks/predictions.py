"""What a probe model predicts from a scan, clipped: the oracle of the model exercises.

Beams within 1° of a sector's edge may count on either side of it, so a scan has several possible
feature vectors, and what is right is an interval of speeds.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import PurePath
from typing import Any

import msgspec
import numpy as np

from grader.checks.case import Interval, exactly
from grader.checks.commands import ZERO
from grader.models.features import Floats, possible_features
from grader.models.files import probe
from grader.recording import Recording, Scan
from sim.scenario import Model, Scenario

MODEL = "velocity_model.pkl"
MAX_SPEED = 0.5  # [m/s] without the parameter
TOLERANCE = 5e-5  # [m/s] of a prediction
BROKEN = ("garbage", "empty", "pickled", "foreign")  # in files that hold no model of their format


def model_file(scenario: Scenario) -> str:
    """Return the parameter model_path that the node was given."""
    return str(scenario.node.parameters.get("model_path", MODEL))


def model_found(scenario: Scenario) -> Model | None:
    """Return the model in the node's file; None if there is none that could be loaded."""
    model = scenario.node.models.get(str(PurePath(model_file(scenario))))
    return None if model is None or model.probe in BROKEN else model


def quick(model: Model) -> Model:
    """Return the model without its delay: the judge needn't wait."""
    if "seconds" not in model.settings:
        return model
    return msgspec.structs.replace(model, settings={**model.settings, "seconds": 0.0})


def max_speed(scenario: Scenario) -> float:
    """Return the parameter max_speed that the node was given [m/s]."""
    return float(scenario.node.parameters.get("max_speed", MAX_SPEED))


@dataclass(frozen=True)
class Prediction:
    """What the model predicts from one scan, clipped."""

    scan: Scan
    least: float  # [m/s]
    most: float  # [m/s]
    missing: bool  # to have no prediction is right as well

    def allows(self, speed: float) -> bool:
        """Return whether a command [m/s] can be this prediction, or 0.0 where there is none."""
        predicted = self.least - TOLERANCE <= speed <= self.most + TOLERANCE
        return predicted or (self.missing and abs(speed) < ZERO)

    @property
    def allowed(self) -> tuple[Interval, ...]:
        """The commands that are right [m/s]."""
        exists = self.most > -math.inf
        return exactly(0.0) * self.missing + ((self.least, self.most),) * exists


def predictions(recording: Recording) -> tuple[Prediction, ...]:
    """Return what the scenario's model, without its delay, predicts from each scan sent."""
    model = probe(quick(recording.scenario.node.models[MODEL]))
    limit = max_speed(recording.scenario)
    return tuple(prediction(model, scan, limit) for scan in recording.scans())


def prediction(model: Any, scan: Scan, limit: float) -> Prediction:
    """Return what a probe (None: no model) predicts from a scan; limit is max_speed [m/s]."""
    rows = () if model is None else possible_features(scan)
    speeds = [_predict(model, features, limit) for features in rows]
    numbers = [speed for speed in speeds if speed is not None]
    if not numbers:
        return Prediction(scan, -math.inf, -math.inf, missing=True)
    return Prediction(scan, min(numbers), max(numbers), missing=len(numbers) < len(speeds))


def _predict(model: Any, features: Floats, limit: float) -> float | None:
    """Return the clipped prediction [m/s] from features (5,); None: no usable one."""
    if not np.isfinite(features).all():
        return None
    try:
        speed = float(model.predict(features[None])[0])
    except Exception:  # a probe that raises does so on purpose
        return None
    return max(0.0, min(limit, speed)) if math.isfinite(speed) else None
