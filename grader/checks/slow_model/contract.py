"""The oracle of slow_model: what the clipped prediction for each recorded scan is."""

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
CONTROL_PERIOD = 0.05  # [s]
LONGEST_GAP = 0.075  # [s] between two commands
MOST_COMMANDS = 21.0  # per second, on average
LEAST_RATE = 3.0  # [Hz] of inference
LEAST_RATE_5_HZ = 2.4  # [Hz] with a lidar of 5 Hz
AGE_P95 = 0.58  # [s] of the scan behind a command
AGE_P95_5_HZ = 0.6  # [s] with a lidar of 5 Hz
MAX_AGE = 0.6  # [s] older scans are worth 0.0 ...
LATEST_STOP = 0.65  # [s] ... one tick later at the latest
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
            return "0.000 m/s (there is no prediction)"
        if self.most - self.least < 0.001:
            return f"{(self.least + self.most) / 2:.3f} m/s"
        return f"{self.least:.3f} to {self.most:.3f} m/s"


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
