"""The core checks of exercise 8, in four files: the node, whatever the format of its model.

The files are read in the order of their names. All core checks sum to 100 points, 26 of them about
PyTorch and Keras.
"""

from __future__ import annotations

import pytest

from grader.checks.commands import require_one_command_each, require_only_linear_x
from grader.checks.predictions import max_speed
from grader.checks.wiring import require_wiring
from grader.exercises.model_formats.evidence import require_speeds
from grader.exercises.model_formats.habits import LONG, READINGS, habits_of, slip
from grader.recording import Recording

GENERAL = (READINGS, LONG, "format_blind", "format_says_pickle")
STANDING = ("format_blind", "format_no_file", "format_raises_pickle")

Recordings = tuple[Recording, ...]


@pytest.mark.check(points=3, scenarios=(READINGS,))
def test_wiring(recordings: Recordings) -> None:
    """The node starts, spins, listens to /scan and publishes on /cmd_vel."""
    for recording in recordings:
        require_wiring(recording, "model_formats")


@pytest.mark.check(points=3, scenarios=GENERAL, needs=("wiring",))
def test_one_command_per_scan(recordings: Recordings) -> None:
    """Each scan is answered by exactly one Twist, and none comes before the first scan."""
    require_one_command_each(recordings[0])
    for recording in recordings[1:]:
        if recording.outcome.completed:  # if not, another check says what it died of
            require_one_command_each(recording)


@pytest.mark.check(points=2, scenarios=(READINGS, *STANDING), needs=("wiring",))
def test_only_linear_x(recordings: Recordings) -> None:
    """Every field of the Twist but linear.x is zero."""
    for recording in recordings:
        spoke = recording.outcome.completed and len(recording.twists().t)
        if spoke or recording is recordings[0]:
            require_only_linear_x(
                recording, "The model only chooses how fast to drive straight ahead."
            )


@pytest.mark.check(points=4, scenarios=(READINGS, LONG), needs=("wiring",))
def test_readings(recordings: Recordings) -> None:
    """The features are those of exercise 2: infinities replaced, unusable readings dropped."""
    wrong = slip(habits_of(recordings[0]))
    for recording in recordings:
        require_speeds(
            recording,
            "readings",
            wrong
            or "Compare with your function of exercise 2, and with its README: +inf and above "
            "range_max is range_max, -inf is range_min, NaN and below range_min is dropped.",
        )


@pytest.mark.check(points=4, scenarios=("format_blind",), needs=("wiring",))
def test_blind_sector(recordings: Recordings) -> None:
    """A sector without a usable reading means 0.0, and the node goes on."""
    for recording in recordings:
        require_speeds(
            recording,
            "blind",
            "Do not ask the model about a scan with a blind sector: command 0.0 and log why.",
        )


@pytest.mark.check(
    points=2,
    scenarios=("format_parameters", "format_held", "format_defaults"),
    needs=("wiring",),
)
def test_parameters(recordings: Recordings) -> None:
    """The parameters model_path and max_speed are obeyed, and have their defaults."""
    for recording in recordings:
        require_speeds(recording, help=_started_with(recording))


def _started_with(recording: Recording) -> str:
    """Return what the node was told, and what to make of it."""
    if not recording.scenario.node.parameters:
        return "Started without parameters: model_path is velocity_model.pkl, and max_speed 0.5."
    if max_speed(recording.scenario) == 0.0:
        return "Started with max_speed:=0.0: 0.0 is a number, too, though it is not true."
    return (
        "Started with model_path:=other.pkl and max_speed:=0.8; the model in velocity_model.pkl "
        "always predicts 0.1."
    )
