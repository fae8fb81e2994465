"""The oracle of ml_velocity: which speeds are right for a scan, given the model of the scenario."""

from __future__ import annotations

from grader.checks.case import Case
from grader.checks.contract import Contract
from grader.checks.predictions import braking, model_found, model_says_go, speed_cases
from grader.recording import Recording

# what a check requires where the judge runs: to make a trained model, to run a training
FOREST = ("sklearn",)
TRAINING = ("sklearn", "skl2onnx", "onnxruntime")

TOLERANCE = 2e-4  # [m/s]; at this the probes tell distances 2.5 mm apart

CONTRACT = Contract(free=model_says_go, nodes=(braking("echo"),))


def cases(recording: Recording) -> list[Case]:
    """Return an occasion for each scan: the speed that the scenario's model predicts, clipped."""
    return speed_cases(recording, model_found(recording.scenario))
