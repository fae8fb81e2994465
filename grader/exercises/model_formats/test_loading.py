"""The core checks of exercise 8 about loading a model, and about running it: odd predictions."""

from __future__ import annotations

from grader.checks.case import Runs
from grader.checks.check import DECISION, SAFETY, STATE, check
from grader.checks.model_commands import ERRORS, loads_once, predicts, stands
from grader.checks.verbs import follows, logs
from grader.exercises.model_formats.contract import KERAS, ONNX, TORCH, deep

FILES = (
    "format_no_file", "format_broken_pickle", "format_empty_pickle", "format_foreign_pickle",
    "format_broken_onnx", "format_late_file",
)  # fmt: skip
DEEP_FILES = (
    "format_broken_torch", "format_broken_keras", "format_pt", "format_late_torch",
    "format_late_keras",
)  # fmt: skip
UNKNOWN = (
    "format_unknown_suffix", "format_no_suffix", "format_backup_suffix", "format_longer_suffix",
)  # fmt: skip
UPPER = ("format_upper_pickle", "format_upper_onnx")
WITHOUT = ("format_without_torch", "format_without_keras")
WITHOUT_ONNX = "format_without_onnxruntime"
ALONE = ("format_pickle_alone", "format_onnx_alone", "format_cuda_alone")
SWAPPED = ("format_swap_pickle", "format_swap_onnx")
DEEP_SWAPPED = ("format_swap_torch", "format_swap_keras")
KNOWN = "Only .pkl, .onnx, .pt2 and .keras are loaded: any other suffix means no model, and 0.0."
LOAD_ONCE = "Load in __init__, keep the model in an attribute, and call that in the callback."
LOAD_LATER = "Import a format's library in the function that loads that format, not at the top."
BOTH = "Whatever the format: the number goes through the same checks."
CUDA = ("format_cuda_pickle", "format_cuda_onnx")
SAYS = "format_says_pickle"
RAISES = ("format_raises_pickle", "format_long_raises")
BOUNDS = ("format_says_onnx", "format_raises_onnx")
DEEP = ("format_says_torch", "format_says_keras", "format_raises_torch", "format_raises_keras")


@check(points=4, asks=DECISION, task=7, scenarios=UPPER, requires=ONNX, hint="7.1")
def test_suffix_in_capitals(runs: Runs) -> None:
    """The suffix is what the path ends in, and may be in capitals: ./MODEL.ONNX, v1.2/Model.Pkl."""
    predicts(runs, "features", help="Path(path).suffix.lower()")


@check(points=5, asks=SAFETY, task=7, scenarios=UNKNOWN, hint="7.1")
def test_unknown_suffix(runs: Runs) -> None:
    """Any other suffix, or none: an error in the log, and 0.0 for every scan."""
    stands(runs, KNOWN)


@check(points=4, asks=SAFETY, task=7, scenarios=FILES, hint="7.2")
def test_no_model(runs: Runs) -> None:
    """A missing or broken file: an error in the log, and 0.0 for every scan."""
    stands(runs)


@check(points=2, asks=SAFETY, task=7, scenarios=DEEP_FILES, requires=KERAS, hint="7.2")
def test_deep_no_model(runs: Runs) -> None:
    """A missing or broken .pt2 or .keras: an error in the log, and 0.0 for every scan."""
    stands(runs)


@check(points=3, asks=SAFETY, task=7, scenarios=WITHOUT, hint="7.2")
def test_no_library(runs: Runs) -> None:
    """PyTorch or Keras is not installed and is needed: an error in the log, and 0.0."""
    stands(runs, LOAD_LATER)


@check(points=3, asks=DECISION, task=7, scenarios=(WITHOUT_ONNX, *ALONE), requires=ONNX, hint="7.2")
def test_other_libraries(runs: Runs) -> None:
    """A library that is not installed matters to its own format only."""
    stands(runs.only(WITHOUT_ONNX), LOAD_LATER)
    predicts(runs.only(*ALONE), "features", help=LOAD_LATER)


@check(points=5, asks=STATE, task=7, scenarios=(*SWAPPED, RAISES[0]), requires=ONNX, hint="7.3")
def test_loads_once(runs: Runs) -> None:
    """The .pkl and the .onnx are loaded once, while the node is constructed."""
    loads_once(runs.only(SWAPPED[0], RAISES[0]))  # the judge keeps these
    follows(runs.only(*SWAPPED), "loads", help=LOAD_ONCE)


@deep(points=2, asks=STATE, task=7, scenarios=DEEP_SWAPPED, hint="7.3")
def test_deep_loads_once(runs: Runs) -> None:
    """The .pt2 and the .keras are loaded once, while the node is constructed."""
    follows(runs, "loads", help=LOAD_ONCE)


@check(points=2, asks=SAFETY, task=8, scenarios=(SAYS,))
def test_clipped(runs: Runs) -> None:
    """The prediction is clipped to 0 … max_speed (0.5 m/s)."""
    predicts(runs, "clip")


@check(points=2, asks=SAFETY, task=8, scenarios=(SAYS, "format_long_nan"))
def test_not_finite(runs: Runs) -> None:
    """A prediction that is not finite means 0.0, and the node goes on."""
    predicts(runs, "not_finite")


@check(points=3, asks=SAFETY, task=8, scenarios=BOUNDS, needs=("onnx",), requires=ONNX)
def test_onnx_bounds(runs: Runs) -> None:
    """The same with .onnx: clipped; 0.0 if not finite, or if the session raises."""
    predicts(runs, help=BOTH)


@deep(points=3, asks=SAFETY, task=8, scenarios=DEEP)
def test_deep_bounds(runs: Runs) -> None:
    """The same with .pt2 and .keras: clipped; 0.0 if not finite, or if the model raises."""
    predicts(runs, help=BOTH)


@check(points=2, asks=SAFETY, task=8, scenarios=RAISES)
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
