"""What a probe model says of each recorded scan, clipped: the oracle of the model exercises."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import msgspec
import numpy as np

from grader.models.features import Floats, possible_features
from grader.models.files import probe
from grader.recording import Recording, Scan
from sim.scenario import Model

MODEL = "velocity_model.pkl"
MAX_SPEED = 0.5  # [m/s] without the parameter
TOLERANCE = 5e-5  # [m/s] of a prediction
ZERO = 1e-6  # [m/s] "zero"


@dataclass(frozen=True)
class Prediction:
    """What the model says of one scan, clipped.

    Beams within 1° of a sector's edge may count on either side, so it is an interval.
    """

    scan: Scan
    least: float  # [m/s]
    most: float  # [m/s]
    missing: bool  # that there is no prediction is right as well

    @property
    def exists(self) -> bool:
        """The model says a number; else 0.0 is right."""
        return self.most > -math.inf

    def allows(self, speed: float) -> bool:
        """Say whether a command [m/s] can be this prediction, or 0.0 where there is none."""
        predicted = self.least - TOLERANCE <= speed <= self.most + TOLERANCE
        return predicted or (self.missing and abs(speed) < ZERO)

    @property
    def text(self) -> str:
        """The prediction in words, for a student."""
        if not self.exists:
            return "0.0000 m/s (there is no prediction)"
        if self.most - self.least < 0.0001:
            return f"{(self.least + self.most) / 2:.4f} m/s" + " or 0.0" * self.missing
        return f"{self.least:.4f} to {self.most:.4f} m/s" + " or 0.0" * self.missing


def predictions(recording: Recording) -> tuple[Prediction, ...]:
    """Return what the scenario's model, without its delay, says of each scan that was sent."""
    node = recording.scenario.node
    limit = float(node.parameters.get("max_speed", MAX_SPEED))
    return _predictions(recording.scans(), msgspec.msgpack.encode(node.models[MODEL]), limit)


@lru_cache(maxsize=32)  # several checks ask for the same
def _predictions(scans: tuple[Scan, ...], packed: bytes, limit: float) -> tuple[Prediction, ...]:
    spec = msgspec.msgpack.decode(packed, type=Model)
    quick = msgspec.structs.replace(spec, settings={**spec.settings, "seconds": 0.0})
    model = probe(quick)
    return tuple(_prediction(model, scan, limit) for scan in scans)


def _prediction(model: Any, scan: Scan, limit: float) -> Prediction:
    said = [_said(model, features, limit) for features in possible_features(scan)]
    numbers = [speed for speed in said if speed is not None]
    if not numbers:
        return Prediction(scan, -math.inf, -math.inf, missing=True)
    return Prediction(scan, min(numbers), max(numbers), missing=len(numbers) < len(said))


def _said(model: Any, features: Floats, limit: float) -> float | None:
    """Return the clipped prediction [m/s]; None: no usable one."""
    if not np.isfinite(features).all():
        return None
    try:
        speed = float(model.predict(features[None])[0])
    except RuntimeError:  # a probe that raises says so on purpose
        return None
    return max(0.0, min(limit, speed)) if math.isfinite(speed) else None
