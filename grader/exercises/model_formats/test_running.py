"""The core checks of exercise 8 about running a model: odd predictions, and the device."""

from __future__ import annotations

from grader.checks.case import Runs
from grader.checks.check import DECISION, SAFETY, check
from grader.checks.model_commands import ERRORS, predicts
from grader.checks.words import logs
from grader.exercises.model_formats.contract import KERAS, ONNX, TORCH

CUDA = ("format_cuda_pickle", "format_cuda_onnx")
SAYS = ("format_says_pickle", "format_says_onnx")
RAISES = ("format_raises_pickle", "format_raises_onnx", "format_long_raises")
DEEP = ("format_says_torch", "format_says_keras", "format_raises_torch", "format_raises_keras")


@check(points=3, asks=SAFETY, task=8, scenarios=SAYS, requires=ONNX)
def test_clipped(runs: Runs) -> None:
    """The prediction is clipped to 0 … max_speed (0.5 m/s)."""
    predicts(runs, "clip")


@check(points=3, asks=SAFETY, task=8, scenarios=(*SAYS, "format_long_nan"), requires=ONNX)
def test_not_finite(runs: Runs) -> None:
    """A prediction that is not finite means 0.0, and the node goes on."""
    predicts(runs, "not_finite")


@check(
    points=3, asks=SAFETY, task=8, scenarios=DEEP, needs=("torch_export", "keras"), requires=KERAS
)
def test_deep_bounds(runs: Runs) -> None:
    """The same with .pt2 and .keras: clipped; 0.0 if not finite, or if the model raises."""
    predicts(runs, help="Whatever the format: the number goes through the same checks.")


@check(points=3, asks=SAFETY, task=8, scenarios=RAISES, requires=ONNX)
def test_model_raises(runs: Runs) -> None:
    """When the model raises, the command is 0.0 and the node goes on."""
    predicts(runs, "raises")


@check(points=2, asks=DECISION, task=5, scenarios=CUDA, requires=ONNX, hint="7.2")
def test_device_ignored(runs: Runs) -> None:
    """With .pkl and .onnx the parameter device changes nothing; a warning is allowed."""
    predicts(runs, "features", help="device concerns PyTorch only.")


@check(
    points=2,
    asks=DECISION,
    task=5,
    scenarios=("format_cuda_torch",),
    needs=("torch_export",),
    requires=TORCH,
    hint="5.3",
)
def test_device_falls_back(runs: Runs) -> None:
    """Without a GPU device = cuda means the CPU, with a warning."""
    help = "Started with device:=cuda, and there is no GPU. Ask torch.cuda.is_available()."
    predicts(runs, "features", help=help)
    for recording in runs:
        if recording.live is None:  # live there may be a GPU
            what = "the node falls back to the CPU"
            logs(recording, ("warn", *ERRORS), what=what, help="Say why it is slow.")
