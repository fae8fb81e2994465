"""The oracle of model_formats: which speeds are right for a scan, given the scenario's model."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import PurePath
from typing import Any

from grader.checks.braking import LINEAR, PICKLE, model_says_go
from grader.checks.contract import Contract, Survived
from grader.checks.predictions import MODEL, SpeedInterval, max_speed, right_speeds
from grader.models.features import Floats
from grader.models.files import is_kept, probe
from grader.recording import Recording, Scan
from sim.scenario import NodeSpec, Scenario

LIBRARIES = {".pkl": "sklearn", ".onnx": "onnxruntime", ".pt2": "torch", ".keras": "keras"}

# what a check requires where the judge runs, to write a file of this format
SKLEARN = ("sklearn",)
ONNX = ("onnx", "onnxruntime")
TORCH = ("torch",)
KERAS = ("torch", "keras")

ORDER = (0, 1, 2, 3, 4)  # of the features
# what there is in files that hold no model of a format
BROKEN = ("garbage", "empty", "pickled", "foreign")

POLICY = "policy.onnx"
CONTRACT = Contract(
    free=model_says_go,
    nodes=(
        NodeSpec(models={PICKLE: LINEAR}),
        NodeSpec(parameters={"model_path": POLICY}, models={POLICY: LINEAR}),
    ),
    delayed_in=("format_drive_pickle", "format_drive_onnx"),
    survives=Survived(sensors=300, commands=300),
)


def model_file(scenario: Scenario) -> str:
    """Return the parameter model_path that the node was given."""
    return str(scenario.node.parameters.get("model_path", MODEL))


def is_known(scenario: Scenario) -> bool:
    """Tell whether the model's suffix is one of the four."""
    return PurePath(model_file(scenario)).suffix.lower() in LIBRARIES


def is_onnx(recording: Recording) -> bool:
    """Tell whether the node was given an ONNX model."""
    return model_file(recording.scenario).lower().endswith(".onnx")


def _name(scenario: Scenario) -> str:
    """Return the name of that model, which has no ./ in front."""
    return str(PurePath(model_file(scenario)))


def right_speed(recording: Recording, scan: Scan, order: tuple[int, ...] = ORDER) -> SpeedInterval:
    """Return the speeds that the contract allows for this scan, the features in this order."""
    scenario, model = recording.scenario, _model(recording.scenario)
    if model is not None and order != ORDER:
        model = _Reordered(model, order)
    return right_speeds(model, scan, max_speed(scenario))


@dataclass(frozen=True)
class _Reordered:
    """A model that gets its features in another order than it was made for."""

    model: Any
    order: tuple[int, ...]

    def predict(self, table: Floats) -> Floats:
        """Return the (n,) speeds [m/s] of (n, 5) features."""
        said: Floats = self.model.predict(table[:, self.order])
        return said


def is_predicted(recording: Recording) -> bool:
    """Tell whether there is a model to ask, and the judge keeps it."""
    scenario, file = recording.scenario, _name(recording.scenario)
    return _model(scenario) is not None and is_kept(file, scenario.node.models[file])


def _model(scenario: Scenario) -> Any:
    """Return what the node ought to have loaded, as a probe; None if there is nothing to load."""
    file = _name(scenario)
    library = LIBRARIES.get(PurePath(file).suffix.lower())
    model = scenario.node.models.get(file)
    if library is None or library in scenario.node.hides or model is None:
        return None
    return None if model.probe in BROKEN else probe(model)
