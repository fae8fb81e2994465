"""The oracle of model_formats: which speeds are right for a scan, given the scenario's model."""

from __future__ import annotations

from pathlib import PurePath
from typing import Any

from grader.checks.predictions import MODEL, SpeedInterval, max_speed, right_speeds
from grader.models.files import is_kept, probe
from grader.recording import Recording, Scan
from sim.scenario import Scenario

LIBRARIES = {".pkl": "sklearn", ".onnx": "onnxruntime", ".pt2": "torch", ".keras": "keras"}

# what a check requires where the judge runs, to write a file of this format
SKLEARN = ("sklearn",)
ONNX = ("onnx", "onnxruntime")
TORCH = ("torch",)
KERAS = ("torch", "keras")


def model_file(scenario: Scenario) -> str:
    """Return the parameter model_path that the node was given."""
    return str(scenario.node.parameters.get("model_path", MODEL))


def right_speed(recording: Recording, scan: Scan) -> SpeedInterval:
    """Return the speeds that the contract allows for this scan."""
    scenario = recording.scenario
    return right_speeds(_model(scenario), scan, max_speed(scenario))


def is_predicted(recording: Recording) -> bool:
    """Tell whether there is a model to ask, and the judge keeps it."""
    scenario, file = recording.scenario, model_file(recording.scenario)
    return _model(scenario) is not None and is_kept(file, scenario.node.models[file])


def _model(scenario: Scenario) -> Any:
    """Return what the node ought to have loaded, as a probe; None if there is nothing to load."""
    file = model_file(scenario)
    library = LIBRARIES.get(PurePath(file).suffix.lower())
    model = scenario.node.models.get(file)
    if library is None or library in scenario.node.hides or model is None:
        return None
    return None if model.probe == "garbage" else probe(model)
