"""The core checks of exercise 8 about running a model: odd predictions, and the device."""

from __future__ import annotations

import pytest

from grader.checks.moments import first_asked
from grader.checks.verdict import fail, passes
from grader.exercises.model_formats.contract import KERAS, ONNX, TORCH
from grader.exercises.model_formats.evidence import Habits, loud_lines, require_speeds
from grader.exercises.model_formats.habits import HABITS, LONG, driven, habits_of
from grader.recording import Recording

Recordings = tuple[Recording, ...]


@pytest.mark.check(
    points=3,
    scenarios=("format_says_pickle", "format_says_onnx", *HABITS),
    needs=("wiring",),
    requires=ONNX,
)
def test_clipped(recordings: Recordings) -> None:
    """The prediction is clipped to 0 … max_speed (0.5 m/s)."""
    *said, readings, onnx = recordings
    habits = habits_of(readings, onnx)
    for recording in driven(said, onnx, habits):
        require_speeds(recording, "clip", "min(max(speed, 0.0), max_speed)", habits)


@pytest.mark.check(
    points=3,
    scenarios=("format_says_pickle", "format_says_onnx", "format_long_nan", LONG, *HABITS),
    needs=("wiring",),
    requires=ONNX,
)
def test_not_finite(recordings: Recordings) -> None:
    """A prediction that is not finite means 0.0, and the node goes on."""
    *said, lasting, long, readings, onnx = recordings
    habits = habits_of(readings, onnx)
    for recording in [*driven(said, onnx, habits), *_if_steady(lasting, long, habits)]:
        require_speeds(
            recording,
            "not_finite",
            "min and max do not stop NaN, and clip +inf to full speed: "
            "ask math.isfinite(speed) first.",
            habits,
        )


@pytest.mark.check(
    points=3,
    scenarios=(
        "format_says_torch",
        "format_says_keras",
        "format_raises_torch",
        "format_raises_keras",
        *HABITS,
    ),
    needs=("torch_export", "keras", "clipped", "not_finite", "model_raises"),
    requires=KERAS + ONNX,
)
def test_deep_bounds(recordings: Recordings) -> None:
    """The same with .pt2 and .keras: clipped; 0.0 if not finite, or if the model raises."""
    *said, readings, onnx = recordings
    for recording in said:
        require_speeds(
            recording,
            help="Whatever the format: one number comes out, and it goes through the same checks.",
            habits=habits_of(readings, onnx),
        )


@pytest.mark.check(
    points=3,
    scenarios=("format_raises_pickle", "format_raises_onnx", "format_long_raises", LONG, *HABITS),
    needs=("wiring",),
    requires=ONNX,
)
def test_model_raises(recordings: Recordings) -> None:
    """When the model raises, the command is 0.0 and the node goes on."""
    *raised, lasting, long, readings, onnx = recordings
    habits = habits_of(readings, onnx)
    for recording in [*driven(raised, onnx, habits), *_if_steady(lasting, long, habits)]:
        require_speeds(
            recording,
            "raises",
            "try: … except Exception as error: around the prediction, and publish 0.0.",
            habits,
        )


@pytest.mark.check(
    points=2,
    scenarios=("format_cuda_pickle", "format_cuda_onnx", *HABITS),
    needs=("wiring",),
    requires=ONNX,
)
def test_device_ignored(recordings: Recordings) -> None:
    """With .pkl and .onnx the parameter device changes nothing; a warning is allowed."""
    *judged, readings, onnx = recordings
    habits = habits_of(readings, onnx)
    for recording in driven(judged, onnx, habits):
        require_speeds(recording, "features", "device concerns PyTorch only.", habits)


@pytest.mark.check(
    points=2,
    scenarios=("format_cuda_torch", *HABITS),
    needs=("torch_export",),
    requires=TORCH + ONNX,
)
def test_device_falls_back(recordings: Recordings) -> None:
    """Without a GPU device = cuda means the CPU, with a warning."""
    *judged, readings, onnx = recordings
    for recording in judged:
        require_speeds(
            recording,
            "features",
            "Started with device:=cuda, and there is no GPU. Ask torch.cuda.is_available().",
            habits_of(readings, onnx),
        )
        if recording.live is None and not loud_lines(recording):  # live there may be a GPU
            fail(
                "the node falls back to the CPU, and its log does not say so",
                expected="a warning in the log: self.get_logger().warning(…)",
                actual="no warning",
                at=first_asked(recording),
                recording=recording,
                help="Whoever asked for a GPU wants to know why it is slow.",
            )


def _if_steady(lasting: Recording, long: Recording, habits: Habits) -> list[Recording]:
    """Return the run of lasting trouble, if the node outlives many scans a second without any."""
    return [lasting] if passes(require_speeds, long, "readings", habits=habits) else []
