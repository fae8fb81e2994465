"""The core checks of exercise 8 about each format: does the node drive as the model says?"""

from __future__ import annotations

import pytest

from grader.checks.model_commands import require_safe_drive
from grader.checks.verdict import passes
from grader.exercises.model_formats.contract import KERAS, ONNX, SKLEARN, TORCH, model_file
from grader.exercises.model_formats.evidence import require_speeds
from grader.exercises.model_formats.habits import HABITS, READINGS, habits_of
from grader.recording import Recording

FEATURES = (
    "The model is linear with five different weights: are the features right, and in their order?"
)
SHAPES = "(n,) and (n, 1) both hold n numbers: np.ravel treats them alike."

Recordings = tuple[Recording, ...]


@pytest.mark.check(
    points=7, scenarios=("format_pickle", READINGS), needs=("wiring",), requires=SKLEARN
)
def test_pickle(recordings: Recordings) -> None:
    """Drives at the speed that a scikit-learn model predicts (.pkl)."""
    *judged, readings = recordings
    for recording in judged:
        require_speeds(recording, "features", FEATURES, habits_of(readings))


@pytest.mark.check(points=8, scenarios=("format_onnx", READINGS), needs=("wiring",), requires=ONNX)
def test_onnx(recordings: Recordings) -> None:
    """Drives at the speed that an ONNX model predicts (.onnx, output (n, 1))."""
    *judged, readings = recordings
    for recording in judged:
        require_speeds(
            recording,
            "features",
            f"{FEATURES} The session wants float32.",
            habits_of(readings),
        )


@pytest.mark.check(
    points=4, scenarios=("format_onnx_flat", *HABITS), needs=("onnx",), requires=ONNX
)
def test_onnx_names(recordings: Recordings) -> None:
    """Takes an ONNX model with other names, and an output of the shape (n,)."""
    *judged, readings, onnx = recordings
    for recording in judged:
        require_speeds(
            recording,
            "features",
            f"Ask the session: get_inputs()[0].name. run(None, …) returns all outputs. {SHAPES}",
            habits_of(readings, onnx),
        )


@pytest.mark.check(
    points=6, scenarios=("format_torch", *HABITS), needs=("wiring",), requires=TORCH + ONNX
)
def test_torch_export(recordings: Recordings) -> None:
    """Drives at the speed that a PyTorch program predicts (.pt2)."""
    *judged, readings, onnx = recordings
    for recording in judged:
        require_speeds(
            recording,
            "features",
            "torch.export.load(path).module() is what can be called, with a float32 tensor (1, 5).",
            habits_of(readings, onnx),
        )


@pytest.mark.check(
    points=6, scenarios=("format_keras", *HABITS), needs=("wiring",), requires=KERAS + ONNX
)
def test_keras(recordings: Recordings) -> None:
    """Drives at the speed that a Keras model predicts (.keras)."""
    *judged, readings, onnx = recordings
    for recording in judged:
        require_speeds(
            recording,
            "features",
            f"{FEATURES} keras.saving.load_model(path) loads it.",
            habits_of(readings, onnx),
        )


@pytest.mark.check(
    points=3,
    scenarios=(
        "format_other_torch",
        "format_other_keras",
        "format_upper_pickle",
        "format_cuda_pickle",
        *HABITS,
    ),
    needs=("torch_export", "keras"),
    requires=KERAS + ONNX,
)
def test_deep_other_models(recordings: Recordings) -> None:
    """Takes other .pt2 and .keras: output (n,), POLICY.PT2, Keras and device = cuda."""
    torch, keras, upper, cuda, readings, onnx = recordings
    habits = habits_of(readings, onnx)
    if passes(require_speeds, upper, "features", habits=habits):  # if not: `suffix_in_capitals`
        require_speeds(
            torch,
            "features",
            f"{SHAPES} The suffix may be in capitals. Keras is not installed here: only .keras "
            "needs it.",
            habits,
        )
    if passes(require_speeds, cuda, "features", habits=habits):  # if not: `device_ignored`
        require_speeds(
            keras, "features", f"{SHAPES} device concerns PyTorch programs only.", habits
        )


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
