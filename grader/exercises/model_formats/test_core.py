"""The core checks of exercise 8, in four files: the node, whatever the format of its model.

The files are read in the order of their names. All core checks sum to 100 points, 26 of them about
PyTorch and Keras.
"""

from __future__ import annotations

from grader.checks.case import Runs
from grader.checks.check import DECISION, SAFETY, WIRING, check
from grader.checks.model_commands import obeys_parameters, predicts
from grader.checks.words import answers_once, only_linear_x, wired

READINGS, LONG, BLIND = "format_readings", "format_hundred", "format_blind"
PARAMETERS = ("format_parameters", "format_held", "format_defaults")
STANDING = (BLIND, "format_no_file", "format_raises_pickle")


@check(points=3, asks=WIRING, task=1, scenarios=(READINGS,), needs=())
def test_wiring(runs: Runs) -> None:
    """The node starts, spins, listens to /scan and publishes on /cmd_vel."""
    wired(runs)


@check(points=3, asks=DECISION, task=8, scenarios=(READINGS, LONG, BLIND, "format_says_pickle"))
def test_one_command_per_scan(runs: Runs) -> None:
    """Each scan is answered by exactly one Twist, and none comes before the first scan."""
    answers_once(runs)


@check(points=2, asks=DECISION, task=8, scenarios=(READINGS, *STANDING))
def test_only_linear_x(runs: Runs) -> None:
    """Every field of the Twist but linear.x is zero."""
    only_linear_x(runs, "The model only chooses how fast to drive straight ahead.")


@check(points=4, asks=DECISION, task=2, scenarios=(READINGS, LONG))
def test_readings(runs: Runs) -> None:
    """The features are those of exercise 2: infinities replaced, unusable readings dropped."""
    predicts(runs, "readings", help="Compare with your function of exercise 2, and its README.")


@check(points=4, asks=SAFETY, task=8, scenarios=(BLIND,))
def test_blind_sector(runs: Runs) -> None:
    """A sector without a usable reading means 0.0, and the node goes on."""
    predicts(runs, "blind")


@check(points=2, asks=WIRING, task=1, scenarios=PARAMETERS)
def test_parameters(runs: Runs) -> None:
    """The parameters model_path and max_speed are obeyed, and have their defaults."""
    obeys_parameters(runs, "0.0 is a number, too, though it is not true.")
