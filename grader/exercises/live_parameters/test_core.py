"""The core checks of exercise 10; they sum to 100 points."""

from __future__ import annotations

from dataclasses import replace

from grader.checks.case import Runs
from grader.checks.check import DECISION, SAFETY, STATE, WIRING, check
from grader.checks.verbs import (
    answers_once,
    follows,
    keeps_distance,
    require_allowed,
    wired,
    within,
)
from grader.exercises.live_parameters.contract import CONTRACT, SET, by_answer, starts_safely

WRONG = "fast near whole true list text nan never inf pair half_a_pair"
STARTS = tuple(f"live_start_{what}" for what in WRONG.split())
HELD = "live_defaults", "live_wall"
NODE = SET.rpartition("/")[0]


@check(points=5, asks=WIRING, task=1, scenarios=("live_defaults",), needs=())
def test_wiring(runs: Runs) -> None:
    """The node starts, spins, listens to /scan and publishes on /cmd_vel."""
    wired(runs)


@check(points=10, asks=WIRING, task=2, scenarios=("live_changed",), hint="2.1")
def test_declared(runs: Runs) -> None:
    """Each parameter is a double, with its range and a description."""
    help = "A ParameterDescriptor has a description, and, for a double, a floating_point_range."
    follows(runs, "describe", topic=f"{NODE}/describe_parameters", help=help)


@check(points=10, asks=DECISION, task=3, scenarios=("live_defaults",), hint="3.1")
def test_defaults(runs: Runs) -> None:
    """With the defaults: 0.3 m/s, 0.15 m/s below 1.0 m, 0 below 0.5 m and blind; once a scan."""
    answers_once(runs)
    help = "d: ±90°, and +inf is free; nothing usable: 0.0, at any speed. 0.5 m is not below 0.5 m."
    follows(runs, "scan", help=help)


@check(points=10, asks=DECISION, task=3, scenarios=("live_started",), hint="3.1")
def test_started(runs: Runs) -> None:
    """The values of the command line, or of a file, are those that it drives by."""
    follows(runs, "scan", help="What does declare_parameter return, if somebody gave a value?")


@check(points=15, asks=STATE, task=4, scenarios=("live_changed",), hint="4.1")
def test_takes_effect(runs: Runs) -> None:
    """A value that is set while the node runs counts from the next scan on."""
    answers_once(runs)
    follows(runs, "accept", topic=SET, help="Does your check return successful=True?")
    follows(runs, "scan", help="Where does the value come from that this decision used?")


@check(points=15, asks=SAFETY, task=5, scenarios=("live_refused",), hint="5.1")
def test_refused(runs: Runs) -> None:
    """What is out of range or no double is refused, with a reason, and changes nothing."""
    help = "NaN is in no range. 2, true and a word are no doubles; dynamic_typing lets them in."
    for recording, case in runs.cases("refuse"):
        if case.count:  # first what it let in, then how that ended it
            require_allowed(recording, case, help, topic=SET)
    follows(runs, "refuse", "accept", topic=SET, help=help)
    follows(runs, "scan", help="After a no the old value counts, after a yes the new one.")


@check(points=10, asks=DECISION, task=5, scenarios=("live_pairs",), hint="5.2")
def test_pairs(runs: Runs) -> None:
    """A slow_distance below the stop_distance is refused, whichever of them is set."""
    help = "Compare the two as they would be: the new value, or else the old; a no changes none."
    follows(runs, "refuse", "accept", topic=SET, help=help)
    follows(runs, "scan", help="After a no both old values count, after a yes what was set.")


@check(points=10, asks=STATE, task=5, scenarios=("live_together",), hint="5.3")
def test_all_or_none(runs: Runs) -> None:
    """By set_parameters_atomically all values count, or none; by set_parameters each by itself."""
    runs = replace(runs, oracle=by_answer)
    follows(runs, "atomically", topic=f"{SET}_atomically", help="One no is a no to all.")
    follows(runs, "set", topic=SET, help="set_parameters asks about each value by itself.")
    follows(runs, "scan", help="A check that also changes the node does so before others say no.")


@check(points=15, asks=SAFETY, task=6, scenarios=(*STARTS, *HELD), hint="6.1")
def test_limits_hold(runs: Runs) -> None:
    """Whatever is set, at the start or later: at most 0.5 m/s, 0 below 0.3 m, by allowed values."""
    starts_safely(replace(runs, oracle=by_answer).only(*STARTS))
    for name in HELD:
        within(runs[name], CONTRACT.limits, "min(…, FASTEST) costs nothing.")
    keeps_distance(runs.only("live_wall"))
