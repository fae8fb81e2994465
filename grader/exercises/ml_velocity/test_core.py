"""The core checks of exercise 2; with those of the training they sum to 100 points."""

from __future__ import annotations

from dataclasses import replace

import pytest

from grader.checks.commands import (
    judged,
    require_one_command_each,
    require_only_linear_x,
)
from grader.checks.inferences import require_kept, require_one_load
from grader.checks.model_commands import require_error_log, require_prompt, require_safe_drive
from grader.checks.wiring import require_wiring
from grader.exercises.ml_velocity.contract import FOREST, LEAST_WAY
from grader.exercises.ml_velocity.evidence import habit_of, require_going_on, require_speeds
from grader.exercises.ml_velocity.habits import SHOWS
from grader.recording import Recording

DRIVES = ("ml_drive_wall", "ml_drive_cart", "ml_drive_store")
WITHOUT_MODEL = (
    "ml_no_model",
    "ml_broken_model",
    "ml_empty_model",
    "ml_foreign_model",
    "ml_late_model",
)
CART_GONE = 8.5  # [s] in ml_drive_cart
SECTOR = "The front sector is |θ| ≤ 60°, with θ = angle_min + i · angle_increment, wrapped to ±π."

Recordings = tuple[Recording, ...]


@pytest.mark.check(points=3, scenarios=("ml_front_min",))
def test_wiring(recordings: Recordings) -> None:
    """The node starts, spins, listens to /scan and publishes on /cmd_vel."""
    for recording in recordings:
        require_wiring(recording, "ml_velocity")


@pytest.mark.check(
    points=3,
    scenarios=(
        "ml_front_min",
        "ml_hundred",
        "ml_stamps",
        "ml_blind",
        "ml_not_finite",
        "ml_raises",
        "ml_drive_wall",
    ),
    needs=("wiring",),
    requires=FOREST,
)
def test_one_command_per_scan(recordings: Recordings) -> None:
    """Each scan is answered by exactly one Twist, and none comes before the first scan."""
    require_one_command_each(recordings[0])
    for recording in recordings[1:]:
        if recording.outcome.completed:  # if not, another check says what it died of
            require_one_command_each(recording)


@pytest.mark.check(
    points=2, scenarios=("ml_front_min", "ml_drive_wall"), needs=("wiring",), requires=FOREST
)
def test_only_linear_x(recordings: Recordings) -> None:
    """Every field of the Twist but linear.x is zero."""
    for recording in recordings:
        require_only_linear_x(recording, "The model only chooses how fast to drive straight ahead.")


@pytest.mark.check(points=4, scenarios=("ml_front_min", "ml_hundred"), needs=("wiring",))
def test_front_min(recordings: Recordings) -> None:
    """Feature 0 is the smallest distance of the front sector (|θ| ≤ 60°)."""
    for recording in recordings:
        require_speeds(recording, help=f"The model echoes feature 0, times 0.08. {SECTOR}")


@pytest.mark.check(points=4, scenarios=("ml_front_mean", SHOWS), needs=("wiring",))
def test_front_mean(recordings: Recordings) -> None:
    """Feature 1 is the mean distance of the front sector."""
    for recording in recordings[:-1]:
        require_speeds(
            recording,
            help=f"The model echoes feature 1, times 0.08. {SECTOR}",
            habit=habit_of(recordings).commands,
        )


@pytest.mark.check(points=4, scenarios=("ml_front_std", SHOWS), needs=("wiring",))
def test_front_std(recordings: Recordings) -> None:
    """Feature 2 is the population standard deviation of the front sector."""
    for recording in recordings[:-1]:
        require_speeds(
            recording,
            help="The model echoes feature 2, times 0.1. Population: divide by n, not by n - 1 "
            "(np.std does, statistics.stdev does not).",
            habit=habit_of(recordings).commands,
        )


@pytest.mark.check(points=3, scenarios=("ml_left_min", SHOWS), needs=("wiring",))
def test_left_min(recordings: Recordings) -> None:
    """Feature 3 is the smallest distance of the left sector (60° < θ ≤ 180°)."""
    for recording in recordings[:-1]:
        require_speeds(
            recording,
            help="The model echoes feature 3, times 0.08. Left is positive (REP-103).",
            habit=habit_of(recordings),
        )


@pytest.mark.check(points=3, scenarios=("ml_right_min", SHOWS), needs=("wiring",))
def test_right_min(recordings: Recordings) -> None:
    """Feature 4 is the smallest distance of the right sector (-180° ≤ θ < -60°)."""
    for recording in recordings[:-1]:
        require_speeds(
            recording,
            help="The model echoes feature 4, times 0.08. Right is negative (REP-103).",
            habit=habit_of(recordings),
        )


@pytest.mark.check(
    points=3,
    scenarios=("ml_infinity", "ml_infinity_left", "ml_limits_far", SHOWS),
    needs=("wiring",),
)
def test_infinite_readings(recordings: Recordings) -> None:
    """+inf and readings above range_max count as range_max."""
    for recording in recordings[:-1]:
        require_speeds(
            recording,
            help="A model cannot compute with inf: replace it by range_max before anything else. "
            "np.minimum(ranges, range_max) does both.",
            habit=habit_of(recordings),
        )


@pytest.mark.check(
    points=3, scenarios=("ml_too_close", "ml_too_close_right", SHOWS), needs=("wiring",)
)
def test_minus_infinity(recordings: Recordings) -> None:
    """-inf counts as range_min."""
    for recording in recordings[:-1]:
        require_speeds(
            recording,
            help="-inf is closer than the sensor can measure: replace it by range_min before you "
            "drop what is below range_min.",
            habit=habit_of(recordings),
        )


@pytest.mark.check(
    points=4,
    scenarios=("ml_invalid", "ml_invalid_left", "ml_limits_near", SHOWS),
    needs=("wiring",),
)
def test_dropped_readings(recordings: Recordings) -> None:
    """NaN and readings below range_min are dropped; the others count."""
    for recording in recordings[:-1]:
        require_speeds(
            recording,
            help="Drop them: neither 0 nor range_min can stand in for a reading without a meaning.",
            habit=habit_of(recordings),
        )


@pytest.mark.check(points=4, scenarios=("ml_blind", SHOWS), needs=("wiring",))
def test_blind_sector(recordings: Recordings) -> None:
    """A sector without a usable reading means 0.0, and the node goes on."""
    for recording in recordings[:-1]:
        require_speeds(
            recording,
            help="Do not ask the model about a scan with a blind sector: command 0.0 and log why.",
            habit=habit_of(recordings),
        )


@pytest.mark.check(points=4, scenarios=("ml_clip",), needs=("wiring",))
def test_clipped(recordings: Recordings) -> None:
    """The prediction is clipped to 0 … max_speed (0.5 m/s)."""
    for recording in recordings:
        require_speeds(recording, help="min(max(speed, 0.0), max_speed)")


@pytest.mark.check(
    points=4,
    scenarios=("ml_parameters", "ml_fast", "ml_held", "ml_defaults", SHOWS),
    needs=("wiring",),
)
def test_parameters(recordings: Recordings) -> None:
    """The parameters model_path and max_speed are obeyed, and have their defaults."""
    # Garbage does not show what it was clipped to.
    habit = replace(habit_of(recordings), garbage=False)
    for recording in recordings[:-1]:
        require_speeds(
            recording,
            help=_started_with(recording),
            habit=habit,
        )


def _started_with(recording: Recording) -> str:
    """Return what the node was told, and what to make of it."""
    given = recording.scenario.node.parameters
    if not given:
        return "Started without parameters: model_path is velocity_model.pkl, and max_speed 0.5."
    return (
        f"Started with model_path:={given['model_path']} and max_speed:={given['max_speed']}; the "
        "model in velocity_model.pkl, if there is one, always predicts 0.1."
    )


@pytest.mark.check(
    points=4, scenarios=("ml_loads_once", "ml_raises", "ml_hundred", SHOWS), needs=("wiring",)
)
def test_loads_once(recordings: Recordings) -> None:
    """The model is loaded once, while the node is constructed, and not again, whatever happens."""
    counted, raising, long, _ = recordings
    for answer in judged(counted):
        require_prompt(counted, answer.scan.t)
        require_one_load(counted, answer.scan.t)
    habit = habit_of(recordings)
    require_speeds(counted, "The model predicts 0.1 m/s if it was loaded once.", habit)
    require_one_load(raising, raising.duration_s)
    require_kept(long, "after a hundred scans or more")


@pytest.mark.check(points=3, scenarios=("ml_not_finite", SHOWS), needs=("wiring",))
def test_not_finite(recordings: Recordings) -> None:
    """A prediction that is not finite means 0.0, and the node goes on."""
    for recording in recordings[:-1]:
        require_speeds(
            recording,
            help="min and max do not stop NaN, and clip +inf to full speed: "
            "ask math.isfinite(speed) first.",
            habit=habit_of(recordings),
        )


@pytest.mark.check(points=3, scenarios=("ml_raises", SHOWS), needs=("wiring",))
def test_model_raises(recordings: Recordings) -> None:
    """When predict raises, the command is 0.0 and the node goes on."""
    for recording in recordings[:-1]:
        require_speeds(
            recording,
            help="try: … except Exception as error: around predict, and publish 0.0.",
            habit=habit_of(recordings),
        )


@pytest.mark.check(points=4, scenarios=WITHOUT_MODEL, needs=("wiring",))
def test_no_model(recordings: Recordings) -> None:
    """Without a model that can be loaded: an error in the log, and 0.0 for every scan."""
    for recording in recordings:
        require_speeds(
            recording,
            help="The node has to live and to publish 0.0 without a model, too. A broken pickle "
            "can raise any exception.",
        )
        require_error_log(recording, "the node has no model, and its log does not say so")


@pytest.mark.check(
    points=3, scenarios=DRIVES, needs=("wiring", "one_command_per_scan"), requires=FOREST
)
def test_drives(recordings: Recordings) -> None:
    """With a trained model the robot drives through three worlds and touches nothing."""
    for recording in recordings:
        require_safe_drive(recording, "the grader's", LEAST_WAY)
        if recording.name == "ml_drive_cart":
            require_going_on(recording, CART_GONE)
