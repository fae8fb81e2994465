"""The core checks of exercise 8 about each format: does the node drive as the model says?"""

from __future__ import annotations

import pytest

from grader.checks.model_commands import require_safe_drive
from grader.checks.model_formats.contract import KERAS, ONNX, SKLEARN, TORCH, model_file
from grader.checks.model_formats.evidence import require_speeds
from grader.recording import Recording

FEATURES = (
    "The model is linear with five different weights: are the features right, and in their order?"
)

Recordings = tuple[Recording, ...]


@pytest.mark.check(points=7, scenarios=("format_pickle",), needs=("wiring",), requires=SKLEARN)
def test_pickle(recordings: Recordings) -> None:
    """Drives at the speed that a scikit-learn model predicts (.pkl)."""
    for recording in recordings:
        require_speeds(recording, "features", FEATURES)


@pytest.mark.check(points=8, scenarios=("format_onnx",), needs=("wiring",), requires=ONNX)
def test_onnx(recordings: Recordings) -> None:
    """Drives at the speed that an ONNX model predicts (.onnx, output (n, 1))."""
    for recording in recordings:
        require_speeds(recording, "features", f"{FEATURES} The session wants float32.")


@pytest.mark.check(points=4, scenarios=("format_onnx_flat",), needs=("onnx",), requires=ONNX)
def test_onnx_names(recordings: Recordings) -> None:
    """Takes an ONNX model with other names, and an output of the shape (n,)."""
    for recording in recordings:
        require_speeds(
            recording,
            "features",
            "Ask the session: get_inputs()[0].name. run(None, …) returns all outputs. (n,) and "
            "(n, 1) both hold n numbers: np.ravel treats them alike.",
        )


@pytest.mark.check(points=7, scenarios=("format_torch",), needs=("wiring",), requires=TORCH)
def test_torch_export(recordings: Recordings) -> None:
    """Drives at the speed that a PyTorch program predicts (.pt2)."""
    for recording in recordings:
        require_speeds(
            recording,
            "features",
            "torch.export.load(path).module() is what can be called, with a float32 tensor (1, 5).",
        )


@pytest.mark.check(points=7, scenarios=("format_keras",), needs=("wiring",), requires=KERAS)
def test_keras(recordings: Recordings) -> None:
    """Drives at the speed that a Keras model predicts (.keras)."""
    for recording in recordings:
        require_speeds(recording, "features", f"{FEATURES} keras.saving.load_model(path) loads it.")


@pytest.mark.check(
    points=2,
    scenarios=("format_drive_pickle", "format_drive_onnx"),
    needs=("one_command_per_scan", "pickle", "onnx"),
    requires=SKLEARN + ONNX,
)
def test_drives(recordings: Recordings) -> None:
    """The same trained decision tree drives the robot as .pkl and as .onnx, without contact."""
    for recording in recordings:
        require_safe_drive(recording, f"the {model_file(recording.scenario)}")


@pytest.mark.check(
    points=2,
    scenarios=("format_drive_torch", "format_drive_keras"),
    needs=("one_command_per_scan", "torch_export", "keras"),
    requires=SKLEARN + KERAS,
)
def test_deep_drives(recordings: Recordings) -> None:
    """The same tree drives the robot as .pt2 and as .keras, without contact."""
    for recording in recordings:
        require_safe_drive(recording, f"the {model_file(recording.scenario)}")
