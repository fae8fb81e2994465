"""The core checks of exercise 11; they sum to 100 points."""

from __future__ import annotations

from grader.checks.case import Runs
from grader.checks.check import DECISION, SAFETY, TIMING, WIRING, check
from grader.checks.commands import FIELDS
from grader.checks.verbs import every, follows, keeps_distance, wired, zero
from grader.exercises.three_nodes.contract import NODES

BENCH, ALONE, WALL = "shuttle_bench", "shuttle_guard", "shuttle_wall"
RAW, DISTANCE = "/shuttle/cmd_vel_raw", "/shuttle/distance"


@check(points=10, asks=WIRING, task=1, scenarios=(BENCH,), needs=(), hint="1.1")
def test_nodes(runs: Runs) -> None:
    """The launch file starts watcher, driver and guard, in the namespace /shuttle."""
    follows(runs, "nodes", topic="the graph", help="namespace=… of Node takes the name.")


@check(points=15, asks=WIRING, task=2, scenarios=(BENCH,), needs=("nodes",), hint="2.1")
def test_connected(runs: Runs) -> None:
    """Each node finds its topics: /scan, distance, cmd_vel_raw, /cmd_vel."""
    wired(runs, *(node.removeprefix("/") for node in NODES))


@check(points=10, asks=SAFETY, task=2, scenarios=(BENCH,), needs=("nodes",), hint="2.2")
def test_only_guard(runs: Runs) -> None:
    """Only the guard publishes on /cmd_vel."""
    follows(runs, "drivers", topic="the graph", help="Who else ends up on /cmd_vel, and by what?")


@check(points=10, asks=DECISION, task=4, scenarios=(BENCH,), needs=("connected",), hint="4.1")
def test_distance(runs: Runs) -> None:
    """The watcher tells the distance ahead of each scan, and nothing of a blind one."""
    follows(runs, "distance", topic=DISTANCE)


@check(points=10, asks=DECISION, task=5, scenarios=(BENCH,), needs=("distance",), hint="5.1")
def test_wishes(runs: Runs) -> None:
    """The driver wants its cruise_speed, and nothing below its stop_distance."""
    follows(runs, "wish", topic=RAW, help="stop_distance itself is far enough.")


@check(points=15, asks=DECISION, task=3, scenarios=(BENCH,), needs=("wishes",), hint="3.1")
def test_parameters(runs: Runs) -> None:
    """The three parameters of the launch file are those that count."""
    follows(runs, "set", topic=RAW, help="Which node gets cruise_speed and stop_distance?")
    follows(runs, "speed", help="Which node gets max_speed?")


@check(points=10, asks=SAFETY, task=6, scenarios=(ALONE,), needs=(), hint="6.1")
def test_limits(runs: Runs) -> None:
    """The guard passes on 0 to max_speed, and 0 for a wish that is no number."""
    follows(runs, "fresh", help="min, max, and math.isfinite.")
    zero(runs[0], FIELDS[1:], "Only linear.x is passed on.")


@check(points=10, asks=TIMING, task=6, scenarios=(ALONE,), needs=("limits",), hint="6.2")
def test_silence(runs: Runs) -> None:
    """The guard speaks 20 times a second, and says 0 when the newest wish is 0.5 s old."""
    every(runs[0], "/cmd_vel", 0.05, 0.01, begin=0.2)
    follows(runs, "old", help="Without a new wish, what does your timer publish?")


@check(points=10, asks=SAFETY, scenarios=(WALL,), needs=("wishes", "limits"), hint="6.2")
def test_keeps_distance(runs: Runs) -> None:
    """The robot drives up to a wall and stops before it; blind, it does not drive."""
    keeps_distance(runs)
    follows(runs, "old", help="No distance, no wish, no speed: where does the chain go on?")
