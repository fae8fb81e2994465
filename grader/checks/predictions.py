"""What a probe model says of each recorded scan, clipped: the oracle of the model exercises."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import msgspec

from grader.checks.features import Floats, right_features
from grader.models import probe
from grader.recording import Recording, Scan

MODEL = "velocity_model.pkl"
TOLERANCE = 5e-5  # [m/s] of a prediction


@dataclass(frozen=True)
class Prediction:
    """What the model says of one scan, clipped.

    Beams within 1° of a sector's edge may count on either side, so it is an interval.
    """

    scan: Scan
    least: float  # [m/s]
    most: float  # [m/s]

    @property
    def exists(self) -> bool:
        """The model says a number; else 0.0 is right."""
        return self.most > -math.inf

    def allows(self, speed: float) -> bool:
        """Say whether a command [m/s] can be this prediction."""
        return self.least - TOLERANCE <= speed <= self.most + TOLERANCE

    @property
    def text(self) -> str:
        """The prediction in words, for a student."""
        if not self.exists:
            return "0.0000 m/s (there is no prediction)"
        if self.most - self.least < 0.0001:
            return f"{(self.least + self.most) / 2:.4f} m/s"
        return f"{self.least:.4f} to {self.most:.4f} m/s"


@dataclass(frozen=True)
class Oracle:
    """The model of a recording's scenario, without its delay."""

    recording: Recording

    @cached_property
    def predictions(self) -> tuple[Prediction, ...]:
        """What it says of each scan that the node was sent."""
        return tuple(self._prediction(scan) for scan in self.recording.scans())

    @cached_property
    def _model(self) -> Any:
        spec = self.recording.scenario.node.models[MODEL]
        return probe(msgspec.structs.replace(spec, settings={**spec.settings, "seconds": 0.0}))

    @property
    def max_speed(self) -> float:
        """The node's parameter max_speed [m/s]."""
        return float(self.recording.scenario.node.parameters.get("max_speed", 0.5))

    def _prediction(self, scan: Scan) -> Prediction:
        said = [self._said(features) for features in right_features(scan)]
        numbers = [speed for speed in said if speed is not None]
        if not numbers:
            return Prediction(scan, -math.inf, -math.inf)
        return Prediction(scan, min(numbers), max(numbers))

    def _said(self, features: Floats | None) -> float | None:
        """Return the clipped prediction [m/s]; None: no usable one."""
        if features is None:
            return None
        try:
            speed = float(self._model.predict(features[None])[0])
        except RuntimeError:  # a probe that raises says so on purpose
            return None
        return max(0.0, min(self.max_speed, speed)) if math.isfinite(speed) else None
