"""The core checks of exercise 2; with those of the training they sum to 100 points."""

from __future__ import annotations

from functools import partial

from grader.checks.case import Runs
from grader.checks.check import DECISION, SAFETY, STATE, WIRING, check
from grader.checks.model_commands import FREE, HELP, loads_once, obeys_parameters, predicts, stands
from grader.checks.verbs import answers_once, drives_on, keeps_distance, only_linear_x, wired
from grader.exercises.ml_velocity.contract import FOREST, TOLERANCE

HUNDRED, WALL, CART = "ml_hundred", "ml_drive_wall", "ml_drive_cart"
ANSWERED = (
    "ml_front_min", HUNDRED, "ml_stamps", "ml_blind", "ml_not_finite", "ml_raises", WALL,
)  # fmt: skip
WITHOUT_MODEL = (
    "ml_no_model", "ml_broken_model", "ml_empty_model", "ml_foreign_model", "ml_late_model",
)  # fmt: skip
INFINITE = ("ml_infinity", "ml_infinity_left", "ml_limits_far")
TOO_CLOSE = ("ml_too_close", "ml_too_close_right")
INVALID = ("ml_invalid", "ml_invalid_left", "ml_limits_near")
PARAMETERS = ("ml_parameters", "ml_fast", "ml_held", "ml_defaults")
SECTOR = "The front sector is |θ| ≤ 60°, with θ = angle_min + i · angle_increment, wrapped to ±π."

follows_model = partial(predicts, tolerance=TOLERANCE)


@check(points=3, asks=WIRING, task=1, scenarios=("ml_front_min",), needs=())
def test_wiring(runs: Runs) -> None:
    """The node starts, spins, listens to /scan and publishes on /cmd_vel."""
    wired(runs)


@check(points=3, asks=DECISION, task=2, scenarios=ANSWERED, requires=FOREST)
def test_one_command_per_scan(runs: Runs) -> None:
    """Each scan is answered by exactly one Twist, and none comes before the first scan."""
    answers_once(runs)


@check(points=2, asks=DECISION, task=2, scenarios=("ml_front_min", WALL), requires=FOREST)
def test_only_linear_x(runs: Runs) -> None:
    """Every field of the Twist but linear.x is zero."""
    only_linear_x(runs, "The model only chooses how fast to drive straight ahead.")


@check(points=4, asks=DECISION, task=4, scenarios=("ml_front_min", HUNDRED), hint="4.1")
def test_front_min(runs: Runs) -> None:
    """Feature 0 is the smallest distance of the front sector (|θ| ≤ 60°)."""
    follows_model(runs, help=f"The model echoes feature 0, times 0.08. {SECTOR}")


@check(points=4, asks=DECISION, task=4, scenarios=("ml_front_mean",), hint="4.3")
def test_front_mean(runs: Runs) -> None:
    """Feature 1 is the mean distance of the front sector."""
    follows_model(runs, help=f"The model echoes feature 1, times 0.08. {SECTOR}")


@check(points=4, asks=DECISION, task=4, scenarios=("ml_front_std",), hint="4.4")
def test_front_std(runs: Runs) -> None:
    """Feature 2 is the population standard deviation of the front sector."""
    help = "The model echoes feature 2, times 0.1. Population: divide by n, not by n - 1 (np.std)."
    follows_model(runs, help=help)


@check(points=3, asks=DECISION, task=4, scenarios=("ml_left_min",), hint="4.3")
def test_left_min(runs: Runs) -> None:
    """Feature 3 is the smallest distance of the left sector (60° < θ ≤ 180°)."""
    follows_model(runs, help="The model echoes feature 3, times 0.08. Left is positive (REP-103).")


@check(points=3, asks=DECISION, task=4, scenarios=("ml_right_min",), hint="4.3")
def test_right_min(runs: Runs) -> None:
    """Feature 4 is the smallest distance of the right sector (-180° ≤ θ < -60°)."""
    follows_model(runs, help="The model echoes feature 4, times 0.08. Right is negative (REP-103).")


@check(points=3, asks=DECISION, task=4, scenarios=INFINITE, hint="4.1")
def test_infinite_readings(runs: Runs) -> None:
    """+inf and readings above range_max count as range_max."""
    help = "A model cannot compute with inf. np.minimum(ranges, range_max), before anything else."
    follows_model(runs, help=help)


@check(points=3, asks=DECISION, task=4, scenarios=TOO_CLOSE, hint="4.1")
def test_minus_infinity(runs: Runs) -> None:
    """-inf counts as range_min."""
    follows_model(runs, help="Replace it by range_min before you drop what is below range_min.")


@check(points=4, asks=DECISION, task=4, scenarios=INVALID, hint="4.1")
def test_dropped_readings(runs: Runs) -> None:
    """NaN and readings below range_min are dropped; the others count."""
    follows_model(runs, help="Neither 0 nor range_min can stand in for them.")


@check(points=4, asks=SAFETY, task=5, scenarios=("ml_blind",), hint="4.5")
def test_blind_sector(runs: Runs) -> None:
    """A sector without a usable reading means 0.0, and the node goes on."""
    follows_model(runs, help=HELP["blind"])


@check(points=4, asks=SAFETY, task=5, scenarios=("ml_clip",), hint="5.2")
def test_clipped(runs: Runs) -> None:
    """The prediction is clipped to 0 … max_speed (0.5 m/s)."""
    follows_model(runs, help=HELP["clip"])


@check(points=4, asks=WIRING, task=5, scenarios=PARAMETERS, hint="1.1")
def test_parameters(runs: Runs) -> None:
    """The parameters model_path and max_speed are obeyed, and have their defaults."""
    help = "A model in velocity_model.pkl that is not asked for always predicts 0.1."
    obeys_parameters(runs, help, TOLERANCE)


@check(points=4, asks=STATE, task=3, scenarios=("ml_loads_once", "ml_raises", HUNDRED), hint="3.1")
def test_loads_once(runs: Runs) -> None:
    """The model is loaded once, while the node is constructed, and not again, whatever happens."""
    loads_once(runs)
    follows_model(runs.only("ml_loads_once"), help="It predicts 0.1 m/s if it was loaded once.")


@check(points=3, asks=SAFETY, task=5, scenarios=("ml_not_finite",), hint="5.2")
def test_not_finite(runs: Runs) -> None:
    """A prediction that is not finite means 0.0, and the node goes on."""
    follows_model(runs, help=HELP["not_finite"])


@check(points=3, asks=SAFETY, task=5, scenarios=("ml_raises",), hint="5.1")
def test_model_raises(runs: Runs) -> None:
    """When predict raises, the command is 0.0 and the node goes on."""
    follows_model(runs, help=HELP["raises"])


@check(points=4, asks=SAFETY, task=3, scenarios=WITHOUT_MODEL, hint="3.2")
def test_no_model(runs: Runs) -> None:
    """Without a model that can be loaded: an error in the log, and 0.0 for every scan."""
    stands(runs)


@check(
    points=3,
    asks=SAFETY,
    scenarios=(WALL, CART, "ml_drive_store"),
    needs=("wiring", "one_command_per_scan"),
    requires=FOREST,
)
def test_drives(runs: Runs) -> None:
    """With a trained model the robot drives through three worlds and touches nothing."""
    keeps_distance(runs, 0.0)
    drives_on(runs.only(CART), FREE, help="Ask the model again at each scan.")
