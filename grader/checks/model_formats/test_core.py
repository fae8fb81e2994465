"""The core checks of exercise 8; they sum to 100 points, 26 of them about PyTorch and Keras."""

from __future__ import annotations

import numpy as np
import pytest

from grader.checks.ml_velocity.evidence import require_prompt, require_safe_drive
from grader.checks.model_formats.contract import model_file
from grader.checks.model_formats.evidence import (
    loud_lines,
    remarks_on_devices,
    require_error_log,
    require_speeds,
)
from grader.checks.moments import first_asked
from grader.checks.obstacle_avoidance.evidence import (
    FIELDS,
    ZERO,
    Answer,
    garbage,
    judged,
    require_one_command_each,
    spell,
)
from grader.checks.verdict import fail
from grader.checks.wiring import require_alive, require_wiring
from grader.recording import Recording

LEARN = ("sklearn",)
ONNX = ("onnx", "onnxruntime")
TORCH = ("torch",)
KERAS = ("torch", "keras")

GENERAL = ("format_readings", "format_blind", "format_says_pickle")
FILES = ("format_no_file", "format_broken_pickle", "format_broken_onnx")
DEEP_FILES = ("format_broken_torch", "format_broken_keras")
LIBRARIES = ("format_without_torch", "format_without_keras")
FIRST = 0.1  # [m/s] says the model that the node was started with
OTHER = 0.4  # [m/s] says the one that took its place

FEATURES = (
    "The model is linear with five different weights: are the features right, and in their order?"
)
LOAD_LATER = "Import a format's library in the function that loads that format, not at the top."

Recordings = tuple[Recording, ...]


@pytest.mark.check(points=3, scenarios=("format_readings",))
def test_wiring(recordings: Recordings) -> None:
    """The node starts, spins, listens to /scan and speaks on /cmd_vel."""
    for recording in recordings:
        require_wiring(recording, "model_formats")


@pytest.mark.check(points=3, scenarios=GENERAL, needs=("wiring",))
def test_one_command_per_scan(recordings: Recordings) -> None:
    """Each scan is answered by exactly one Twist, and nothing is said before the first scan."""
    require_one_command_each(recordings[0])
    for recording in recordings[1:]:
        if recording.outcome.completed:  # of what it died, another check says
            require_one_command_each(recording)


@pytest.mark.check(points=2, scenarios=("format_readings",), needs=("wiring",))
def test_only_linear_x(recordings: Recordings) -> None:
    """Every field of the Twist but linear.x is zero."""
    for recording in recordings:
        twists = recording.twists()
        if not len(twists.t):
            fail(
                "not a single Twist came on /cmd_vel",
                at=first_asked(recording),
                recording=recording,
            )
        for column in range(1, 6):
            wrong = np.flatnonzero(~(np.abs(twists.values[:, column]) < ZERO))
            if len(wrong):
                value = float(twists.values[wrong[0], column])
                fail(
                    f"{FIELDS[column]} is not zero",
                    expected=f"{FIELDS[column]} = 0.0",
                    actual=f"{FIELDS[column]} = {spell(value)}",
                    at=float(twists.t[wrong[0]]),
                    recording=recording,
                    help=garbage(value) or "The model says how fast, and only straight ahead.",
                )


@pytest.mark.check(points=4, scenarios=("format_readings",), needs=("wiring",))
def test_readings(recordings: Recordings) -> None:
    """The features are those of exercise 2: infinities replaced, what says nothing dropped."""
    for recording in recordings:
        require_speeds(
            recording,
            "readings",
            "Compare with your function of exercise 2, and with its README: +inf and above "
            "range_max is range_max, -inf is range_min, NaN and below range_min is dropped.",
        )


@pytest.mark.check(points=4, scenarios=("format_blind",), needs=("wiring",))
def test_blind_sector(recordings: Recordings) -> None:
    """A sector without a usable reading means 0.0, and the node goes on."""
    for recording in recordings:
        require_speeds(
            recording,
            "blind",
            "Do not ask the model about a scan that lacks a sector: command 0.0 and log why.",
        )


@pytest.mark.check(points=2, scenarios=("format_parameters",), needs=("wiring",))
def test_parameters(recordings: Recordings) -> None:
    """The parameters model_path and max_speed are obeyed."""
    for recording in recordings:
        require_speeds(
            recording,
            help="Started with model_path:=other.pkl and max_speed:=0.3; the model in "
            "velocity_model.pkl always says 0.1.",
        )


# --- the formats ----------------------------------------------------------------------------------


@pytest.mark.check(points=7, scenarios=("format_pickle",), needs=("readings",), requires=LEARN)
def test_pickle(recordings: Recordings) -> None:
    """Drives as a model of scikit-learn says (.pkl)."""
    for recording in recordings:
        require_speeds(recording, "features", FEATURES)


@pytest.mark.check(points=8, scenarios=("format_onnx",), needs=("readings",), requires=ONNX)
def test_onnx(recordings: Recordings) -> None:
    """Drives as an ONNX model says (.onnx), whose output has the shape (n, 1)."""
    for recording in recordings:
        require_speeds(recording, "features", f"{FEATURES} The session wants float32.")


@pytest.mark.check(points=4, scenarios=("format_onnx_flat",), needs=("onnx",), requires=ONNX)
def test_onnx_names(recordings: Recordings) -> None:
    """Takes an ONNX model whose names are others, and whose output has the shape (n,)."""
    for recording in recordings:
        require_speeds(
            recording,
            "features",
            "Ask the session: get_inputs()[0].name. run(None, …) returns all outputs. (n,) and "
            "(n, 1) both hold n numbers: np.ravel makes the same of them.",
        )


@pytest.mark.check(points=7, scenarios=("format_torch",), needs=("readings",), requires=TORCH)
def test_torch_export(recordings: Recordings) -> None:
    """Drives as a PyTorch program says (.pt2)."""
    for recording in recordings:
        require_speeds(
            recording,
            "features",
            "torch.export.load(path).module() is what can be called, with a float32 tensor (1, 5).",
        )


@pytest.mark.check(points=7, scenarios=("format_keras",), needs=("readings",), requires=KERAS)
def test_keras(recordings: Recordings) -> None:
    """Drives as a Keras model says (.keras)."""
    for recording in recordings:
        require_speeds(recording, "features", f"{FEATURES} keras.saving.load_model(path) loads it.")


@pytest.mark.check(
    points=2,
    scenarios=("format_drive_pickle", "format_drive_onnx"),
    needs=("one_command_per_scan", "pickle", "onnx"),
    requires=LEARN + ONNX,
)
def test_drives(recordings: Recordings) -> None:
    """The same trained decision tree drives the robot as .pkl and as .onnx, without contact."""
    for recording in recordings:
        require_safe_drive(recording, f"the {model_file(recording.scenario)}")


@pytest.mark.check(
    points=2,
    scenarios=("format_drive_torch", "format_drive_keras"),
    needs=("one_command_per_scan", "torch_export", "keras"),
    requires=LEARN + KERAS,
)
def test_deep_drives(recordings: Recordings) -> None:
    """The same tree drives the robot as .pt2 and as .keras, without contact."""
    for recording in recordings:
        require_safe_drive(recording, f"the {model_file(recording.scenario)}")


# --- which format? --------------------------------------------------------------------------------


@pytest.mark.check(
    points=4,
    scenarios=("format_upper_onnx", "format_upper_pickle"),
    needs=("onnx",),
    requires=ONNX,
)
def test_suffix_in_capitals(recordings: Recordings) -> None:
    """The suffix counts in capitals, too: MODEL.ONNX, Model.Pkl."""
    for recording in recordings:
        require_speeds(recording, "features", "Path(path).suffix.lower()")


@pytest.mark.check(
    points=5, scenarios=("format_unknown_suffix", "format_no_suffix"), needs=("wiring",)
)
def test_unknown_suffix(recordings: Recordings) -> None:
    """Any other suffix, or none: an error in the log, and 0.0 for every scan."""
    for recording in recordings:
        _require_standing(recording, f"{model_file(recording.scenario)} has no suffix that counts")


@pytest.mark.check(points=4, scenarios=FILES, needs=("wiring",))
def test_no_model(recordings: Recordings) -> None:
    """A missing or broken file: an error in the log, and 0.0 for every scan."""
    for recording in recordings:
        what = "is broken" if recording.scenario.node.models else "does not exist"
        _require_standing(recording, f"{model_file(recording.scenario)} {what}")


@pytest.mark.check(points=2, scenarios=DEEP_FILES, needs=("wiring",), requires=KERAS)
def test_deep_no_model(recordings: Recordings) -> None:
    """A broken .pt2 or .keras: an error in the log, and 0.0 for every scan."""
    for recording in recordings:
        _require_standing(recording, f"{model_file(recording.scenario)} is broken")


@pytest.mark.check(points=3, scenarios=LIBRARIES, needs=("wiring",))
def test_no_library(recordings: Recordings) -> None:
    """PyTorch or Keras is not installed and is needed: an error in the log, and 0.0."""
    for recording in recordings:
        library = recording.scenario.node.hides[0]
        _require_standing(recording, f"{library} is not installed", LOAD_LATER)


@pytest.mark.check(
    points=3,
    scenarios=("format_without_onnxruntime", "format_pickle_alone"),
    needs=("wiring",),
    requires=ONNX,
)
def test_other_libraries(recordings: Recordings) -> None:
    """A library that is not installed matters to its own format only."""
    without, alone = recordings
    _require_standing(without, "onnxruntime is not installed", LOAD_LATER)
    require_speeds(alone, "features", LOAD_LATER)


# --- once -----------------------------------------------------------------------------------------


@pytest.mark.check(
    points=5,
    scenarios=("format_swap_pickle", "format_swap_onnx"),
    needs=("onnx",),
    requires=ONNX,
)
def test_loads_once(recordings: Recordings) -> None:
    """The .pkl and the .onnx are loaded once, while the node is constructed."""
    for recording in recordings:
        for answer in judged(recording, "loads"):
            require_prompt(recording, answer.scan.t)
            _require_first(recording, answer)


@pytest.mark.check(
    points=3,
    scenarios=("format_swap_torch", "format_swap_keras"),
    needs=("torch_export", "keras"),
    requires=KERAS,
)
def test_deep_loads_once(recordings: Recordings) -> None:
    """The .pt2 and the .keras are loaded once, while the node is constructed."""
    for recording in recordings:
        for answer in judged(recording, "loads"):
            _require_first(recording, answer)


# --- what models say ------------------------------------------------------------------------------


@pytest.mark.check(
    points=3,
    scenarios=("format_says_pickle", "format_says_onnx"),
    needs=("onnx",),
    requires=ONNX,
)
def test_clipped(recordings: Recordings) -> None:
    """The prediction is clipped to 0 … max_speed (0.5 m/s)."""
    for recording in recordings:
        require_speeds(recording, "clip", "min(max(speed, 0.0), max_speed)")


@pytest.mark.check(
    points=3,
    scenarios=("format_says_pickle", "format_says_onnx"),
    needs=("onnx",),
    requires=ONNX,
)
def test_not_finite(recordings: Recordings) -> None:
    """A prediction that is not finite means 0.0, and the node goes on."""
    for recording in recordings:
        require_speeds(
            recording,
            "not_finite",
            "min and max do not stop NaN, and clip +inf to full speed: "
            "ask math.isfinite(speed) first.",
        )


@pytest.mark.check(
    points=3,
    scenarios=("format_says_torch", "format_says_keras"),
    needs=("torch_export", "keras", "clipped", "not_finite"),
    requires=KERAS,
)
def test_deep_bounds(recordings: Recordings) -> None:
    """What a .pt2 and a .keras say is clipped, too, and not finite means 0.0."""
    for recording in recordings:
        require_speeds(
            recording,
            help="Whatever the format: one number comes out, and it goes through the same checks.",
        )


@pytest.mark.check(
    points=3,
    scenarios=("format_raises_pickle", "format_raises_onnx"),
    needs=("onnx",),
    requires=ONNX,
)
def test_model_raises(recordings: Recordings) -> None:
    """When the model raises, the command is 0.0 and the node goes on."""
    for recording in recordings:
        require_speeds(
            recording,
            "raises",
            "try: … except Exception as error: around the prediction, and publish 0.0.",
        )


# --- device ---------------------------------------------------------------------------------------


@pytest.mark.check(
    points=2,
    scenarios=("format_cuda_pickle", "format_cuda_onnx"),
    needs=("onnx",),
    requires=ONNX,
)
def test_device_ignored(recordings: Recordings) -> None:
    """With .pkl and .onnx the parameter device is ignored, without a warning."""
    for recording in recordings:
        require_speeds(recording, "features", "device concerns PyTorch only.")
        for line in remarks_on_devices(recording)[:1]:
            fail(
                f"device:=cuda means nothing to {model_file(recording.scenario)}, "
                "and the node complains",
                expected="no warning: the parameter concerns PyTorch only",
                actual=line.text.strip(),
                at=line.time,
                recording=recording,
                help="Look for a GPU only when a .pt2 is loaded.",
            )


@pytest.mark.check(
    points=2, scenarios=("format_cuda_torch",), needs=("torch_export",), requires=TORCH
)
def test_device_falls_back(recordings: Recordings) -> None:
    """Without a GPU device = cuda means the CPU, with a warning."""
    for recording in recordings:
        require_speeds(
            recording,
            "features",
            "Started with device:=cuda, and there is no GPU. torch.cuda.is_available() tells.",
        )
        if recording.live is None and not loud_lines(recording):  # live there may be a GPU
            fail(
                "the node falls back to the CPU and does not say so",
                expected="a warning in the log: self.get_logger().warning(…)",
                actual="no warning",
                at=first_asked(recording),
                recording=recording,
                help="Who asked for a GPU wants to know why it is slow.",
            )


def _require_standing(recording: Recording, why: str, help: str = "") -> None:
    """Fail unless the node lived, stood still and said that something is wrong."""
    require_alive(recording)
    require_speeds(
        recording,
        help=help or "The node has to live and to publish 0.0 without a model, too.",
    )
    require_error_log(recording, why)


def _require_first(recording: Recording, answer: Answer) -> None:
    """Fail unless the command is that of the model that was there at the start."""
    speed = answer.speed
    if speed is not None and abs(speed - FIRST) <= 1e-3:
        return
    file = model_file(recording.scenario)
    said = "nothing" if speed is None else f"linear.x = {spell(speed)} m/s"
    if speed is not None and abs(speed - OTHER) <= 1e-3:
        problem = f"{file} was loaded again, or only when the first scan came"
        said += ", what the file says that took its place at 0.25 s"
    elif speed is not None and speed > FIRST and file.endswith(".pkl"):
        problem = (
            f"{file} was loaded {speed / FIRST:.0f} times by the scan at {answer.scan.t:.3f} s"
        )
    else:
        problem = f"the node does not drive as the {file} says with which it was started"
    fail(
        problem,
        expected=f"linear.x = {FIRST:.2f} m/s, what the model says that was there at the start",
        actual=said,
        at=answer.scan.t,
        recording=recording,
        help="Load in __init__, keep the session or module in an attribute, call it in the "
        "callback.",
    )
