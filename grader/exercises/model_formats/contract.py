"""The oracle of model_formats: which speeds are right for a scan, given the scenario's model."""

from __future__ import annotations

from functools import partial
from pathlib import PurePath

from grader.checks.case import Case
from grader.checks.check import check
from grader.checks.contract import Contract
from grader.checks.predictions import (
    LINEAR,
    MODEL,
    model_file,
    model_found,
    model_says_go,
    speed_cases,
)
from grader.recording import Recording
from sim.scenario import NodeSpec

LIBRARIES = {".pkl": "sklearn", ".onnx": "onnxruntime", ".pt2": "torch", ".keras": "keras"}

# what a check requires where the judge runs, to write a file of this format
SKLEARN = ("sklearn",)
ONNX = ("onnx", "onnxruntime")
TORCH = ("torch",)
KERAS = ("torch", "keras")
deep = partial(check, needs=("torch_export", "keras"), requires=KERAS)

POLICY = "policy.onnx"
CONTRACT = Contract(
    free=model_says_go,
    nodes=(
        NodeSpec(models={MODEL: LINEAR}),
        NodeSpec(parameters={"model_path": POLICY}, models={POLICY: LINEAR}),
    ),
)


def cases(recording: Recording) -> list[Case]:
    """Return an occasion for each scan: the speed that the model predicts, clipped.

    There is a model to ask if its suffix is known, its library there and its file whole.
    """
    scenario = recording.scenario
    library = LIBRARIES.get(PurePath(model_file(scenario)).suffix.lower())
    loads = library is not None and library not in scenario.node.hides
    return speed_cases(recording, model_found(scenario) if loads else None)
