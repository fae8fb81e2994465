"""The core checks of exercise 8 about loading: which format, which library, and once."""

from __future__ import annotations

import pytest

from grader.checks.commands import Answer, judged, spell
from grader.checks.inferences import require_kept, require_one_load
from grader.checks.model_commands import require_error_log, require_prompt
from grader.checks.predictions import SpeedInterval
from grader.checks.verdict import fail, passes
from grader.checks.wiring import require_alive
from grader.exercises.model_formats.contract import KERAS, ONNX, is_known, model_file
from grader.exercises.model_formats.evidence import ERRORS, Habits, as_meant, require_speeds
from grader.exercises.model_formats.habits import HABITS, driven, habits_of
from grader.recording import Recording

NO_FILE, LATE_FILE = "format_no_file", "format_late_file"
FILES = (
    NO_FILE,
    "format_broken_pickle",
    "format_empty_pickle",
    "format_foreign_pickle",
    "format_broken_onnx",
    LATE_FILE,
)
DEEP_FILES = ("format_broken_torch", "format_broken_keras", "format_pt")
DEEP_LATE = ("format_late_torch", "format_late_keras")
LIBRARIES = ("format_without_torch", "format_without_keras")

FIRST = 0.1  # [m/s] predicted by the model that the node was started with
OTHER = 0.4  # [m/s] predicted by the one that took its place

PICKLE = ".pkl"

KNOWN = (
    "Only .pkl, .onnx, .pt2 and .keras are loaded: with any other suffix, or none, there is no "
    "model, and the node publishes 0.0."
)
LOAD_LATER = "Import a format's library in the function that loads that format, not at the top."

Recordings = tuple[Recording, ...]


@pytest.mark.check(
    points=4,
    scenarios=("format_upper_pickle", "format_upper_onnx", *HABITS),
    needs=("wiring",),
    requires=ONNX,
)
def test_suffix_in_capitals(recordings: Recordings) -> None:
    """The suffix is what the path ends in, and may be in capitals: ./MODEL.ONNX, v1.2/Model.Pkl."""
    *upper, readings, onnx = recordings
    habits = habits_of(readings, onnx)
    for recording in driven(upper, onnx, habits):
        require_speeds(recording, "features", "Path(path).suffix.lower()", habits)


@pytest.mark.check(
    points=5,
    scenarios=(
        "format_unknown_suffix",
        "format_no_suffix",
        "format_backup_suffix",
        "format_longer_suffix",
        NO_FILE,
    ),
    needs=("wiring",),
)
def test_unknown_suffix(recordings: Recordings) -> None:
    """Any other suffix, or none: an error in the log, and 0.0 for every scan."""
    *judged, no_file = recordings
    for recording in judged:
        why = f"{model_file(recording.scenario)} has no known suffix"
        _require_standing(recording, why, KNOWN, as_in=no_file)


@pytest.mark.check(points=4, scenarios=FILES, needs=("wiring",))
def test_no_model(recordings: Recordings) -> None:
    """A missing or broken file: an error in the log, and 0.0 for every scan."""
    for recording in recordings:
        what = _state_of_file(recording)
        _require_standing(recording, f"{model_file(recording.scenario)} {what}")


def _state_of_file(recording: Recording) -> str:
    """Return what is the matter with the node's file, in words."""
    probes = {
        "": "does not exist",
        "empty": "is empty",
        "pickled": "holds a pickle, and no ONNX",
        "foreign": "holds an object of a class that is not here",
    }
    models, file = recording.scenario.node.models, model_file(recording.scenario)
    return probes.get(models[file].probe if file in models else "", "is broken")


@pytest.mark.check(
    points=2,
    scenarios=(*DEEP_FILES, *DEEP_LATE, LATE_FILE, NO_FILE),
    needs=("wiring",),
    requires=KERAS,
)
def test_deep_no_model(recordings: Recordings) -> None:
    """A missing or broken .pt2 or .keras: an error in the log, and 0.0 for every scan."""
    *judged, late_file, no_file = recordings
    if not passes(require_speeds, late_file):  # tries again: `no_model` says so
        judged = judged[: len(DEEP_FILES)]
    for recording in judged:
        if not is_known(recording.scenario):
            if recording.outcome.completed:  # if not, `unknown_suffix` says what it died of
                _require_zeros(recording, KNOWN, as_in=no_file)
            continue
        why = f"{model_file(recording.scenario)} {_state_of_file(recording)}"
        _require_standing(recording, why, as_in=no_file)


@pytest.mark.check(points=3, scenarios=(*LIBRARIES, NO_FILE), needs=("wiring",))
def test_no_library(recordings: Recordings) -> None:
    """PyTorch or Keras is not installed and is needed: an error in the log, and 0.0."""
    *judged, no_file = recordings
    for recording in judged:
        library = recording.scenario.node.hides[0]
        _require_standing(recording, f"{library} is not installed", LOAD_LATER, as_in=no_file)


@pytest.mark.check(
    points=3,
    scenarios=(
        "format_without_onnxruntime",
        "format_pickle_alone",
        "format_onnx_alone",
        "format_cuda_alone",
        "format_cuda_pickle",
        *HABITS,
        NO_FILE,
    ),
    needs=("wiring",),
    requires=ONNX,
)
def test_other_libraries(recordings: Recordings) -> None:
    """A library that is not installed matters to its own format only."""
    without, *alone, with_cuda, cuda, readings, onnx, no_file = recordings
    _require_standing(without, "onnxruntime is not installed", LOAD_LATER, as_in=no_file)
    habits = habits_of(readings, onnx)
    if passes(require_speeds, cuda, "features", habits=habits):  # if not: `device_ignored`
        alone.append(with_cuda)
    for recording in driven(alone, onnx, habits):
        require_speeds(recording, "features", LOAD_LATER, habits)


@pytest.mark.check(
    points=5,
    scenarios=("format_swap_pickle", "format_swap_onnx", "format_raises_pickle", *HABITS),
    needs=("wiring",),
    requires=ONNX,
)
def test_loads_once(recordings: Recordings) -> None:
    """The .pkl and the .onnx are loaded once, while the node is constructed."""
    *swapped, failing, readings, onnx = recordings
    habits = habits_of(readings, onnx)
    for recording in driven(swapped, onnx, habits):
        for answer in judged(recording, "loads"):
            require_prompt(recording, answer.scan.t)
            if model_file(recording.scenario).endswith(PICKLE):  # the judge keeps this one
                require_one_load(recording, answer.scan.t)
            _require_first(recording, answer, habits)
    require_kept(failing)


@pytest.mark.check(
    points=2,
    scenarios=("format_swap_torch", "format_swap_keras", *HABITS),
    needs=("torch_export", "keras"),
    requires=KERAS + ONNX,
)
def test_deep_loads_once(recordings: Recordings) -> None:
    """The .pt2 and the .keras are loaded once, while the node is constructed."""
    *swapped, readings, onnx = recordings
    habits = habits_of(readings, onnx)
    for recording in swapped:
        for answer in judged(recording, "loads"):
            _require_first(recording, answer, habits)


def _require_standing(
    recording: Recording, why: str, help: str = "", as_in: Recording | None = None
) -> None:
    """Fail unless the node ran to the end, commanded 0.0 and logged an error.

    What it never does without a model is a matter for `no_model`: of a node that, in the run
    `as_in`, publishes nothing or logs no error, that is not asked again.
    """
    require_alive(recording)
    _require_zeros(
        recording, help or "The node has to live and to publish 0.0 without a model, too.", as_in
    )
    if as_in is None or any(line.level in ERRORS for line in as_in.log):
        require_error_log(recording, f"{why}, and its log does not say so")


def _require_zeros(recording: Recording, help: str, as_in: Recording | None) -> None:
    """Fail unless the node commanded 0.0 all the time; it is silent if it is so in `as_in`."""
    if as_in is None or len(as_in.twists().t) or len(recording.twists().t):
        require_speeds(recording, help=help)


def _require_first(recording: Recording, answer: Answer, habits: Habits) -> None:
    """Fail unless the command is that of the model that was there at the start."""
    speed = answer.speed
    for one in (FIRST, OTHER):
        speed = as_meant(speed, SpeedInterval(one, one), habits)
    if speed is not None and abs(speed - FIRST) <= 1e-3:
        return
    file = model_file(recording.scenario)
    said = "nothing" if speed is None else f"linear.x = {spell(speed)} m/s"
    if speed is not None and abs(speed - OTHER) <= 1e-3:
        problem = f"{file} was loaded again, or only when the first scan came"
        said += ", from the file that replaced it at 0.25 s"
    else:
        problem = f"the node does not follow the {file} that it was started with"
    fail(
        problem,
        expected=f"linear.x = {FIRST:.2f} m/s, from the file that was there at the start",
        actual=said,
        at=answer.scan.t,
        recording=recording,
        help="Load in __init__, keep the session or module in an attribute, call it in the "
        "callback.",
    )
