"""The core checks of exercise 8 about each format: does the node drive as the model says?"""

from __future__ import annotations

from grader.checks.case import Runs
from grader.checks.check import DECISION, SAFETY, check
from grader.checks.model_commands import FREE, predicts
from grader.checks.words import drives_on, keeps_distance
from grader.exercises.model_formats.contract import KERAS, ONNX, SKLEARN, TORCH

FEATURES = "The model has five different weights: are the features right, and in their order?"
SHAPES = "(n,) and (n, 1) both hold n numbers: np.ravel treats them alike."


@check(points=7, asks=DECISION, task=3, scenarios=("format_pickle",), requires=SKLEARN, hint="3.1")
def test_pickle(runs: Runs) -> None:
    """Drives at the speed that a scikit-learn model predicts (.pkl)."""
    predicts(runs, "features", help=FEATURES)


@check(points=8, asks=DECISION, task=4, scenarios=("format_onnx",), requires=ONNX, hint="4.1")
def test_onnx(runs: Runs) -> None:
    """Drives at the speed that an ONNX model predicts (.onnx, output (n, 1))."""
    predicts(runs, "features", help=f"{FEATURES} The session wants float32.")


@check(
    points=4,
    asks=DECISION,
    task=4,
    scenarios=("format_onnx_flat",),
    needs=("onnx",),
    requires=ONNX,
    hint="4.2",
)
def test_onnx_names(runs: Runs) -> None:
    """Takes an ONNX model with other names, and an output of the shape (n,)."""
    predicts(runs, "features", help=f"Ask the session: get_inputs()[0].name. {SHAPES}")


@check(points=6, asks=DECISION, task=5, scenarios=("format_torch",), requires=TORCH, hint="5.1")
def test_torch_export(runs: Runs) -> None:
    """Drives at the speed that a PyTorch program predicts (.pt2)."""
    help = "torch.export.load(path).module() is what can be called, with a float32 tensor (1, 5)."
    predicts(runs, "features", help=help)


@check(points=6, asks=DECISION, task=6, scenarios=("format_keras",), requires=KERAS, hint="6.1")
def test_keras(runs: Runs) -> None:
    """Drives at the speed that a Keras model predicts (.keras)."""
    predicts(runs, "features", help=f"{FEATURES} keras.saving.load_model(path) loads it.")


@check(
    points=3,
    asks=DECISION,
    task=7,
    scenarios=("format_other_torch", "format_other_keras"),
    needs=("torch_export", "keras"),
    requires=KERAS,
)
def test_deep_other_models(runs: Runs) -> None:
    """Takes other .pt2 and .keras: output (n,), POLICY.PT2, Keras and device = cuda."""
    predicts(runs, "features", help=f"{SHAPES} The suffix may be in capitals.")


@check(
    points=2,
    asks=SAFETY,
    scenarios=("format_drive_pickle", "format_drive_onnx"),
    needs=("one_command_per_scan", "pickle", "onnx"),
    requires=SKLEARN + ONNX,
)
def test_drives(runs: Runs) -> None:
    """The same trained decision tree drives the robot as .pkl and as .onnx, without contact."""
    keeps_distance(runs, 0.0)
    drives_on(runs, FREE)


@check(
    points=2,
    asks=SAFETY,
    scenarios=("format_drive_torch", "format_drive_keras"),
    needs=("one_command_per_scan", "torch_export", "keras"),
    requires=SKLEARN + KERAS,
)
def test_deep_drives(runs: Runs) -> None:
    """The same tree drives the robot as .pt2 and as .keras, without contact."""
    keeps_distance(runs, 0.0)
    drives_on(runs, FREE)
