"""The core checks of exercise 11; they sum to 100 points.

The launch file is judged with programs of the course's own, each program alone, then all together.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from grader.checks.case import Case, Runs, spell_allowed
from grader.checks.check import DECISION, SAFETY, TIMING, WIRING, check
from grader.checks.commands import FIELDS
from grader.checks.verbs import TOLERANCE, every, follows, keeps_distance, wired, within, zero
from grader.checks.verdict import fail
from grader.checks.wiring import require_alive, require_end
from grader.course.exercises import Topic
from grader.exercises.three_nodes.contract import CONTRACT, GIVEN, NODES, PATIENCE, given
from grader.recording import Recording
from sim.messages import CMD_VEL_RAW_TOPIC, CMD_VEL_TOPIC, TWIST

LAUNCH, BENCH, WALL = "shuttle_launch", "shuttle_bench", "shuttle_wall"
WATCHER, DRIVER, GUARD = "shuttle_watcher", "shuttle_driver", "shuttle_guard"
CHAIN = "No distance, no wish, no speed: where does the chain go on?"
PERIOD = "create_timer takes seconds: 0.05."
EACH_TICK = "Other ticks did. Does one return early, where the wish is old? It publishes 0.0."
RAW, DISTANCE = "/shuttle/cmd_vel_raw", "/shuttle/distance"


@check(points=10, asks=WIRING, task=1, scenarios=(LAUNCH, BENCH), needs=(), hint="1.1")
def test_nodes(runs: Runs) -> None:
    """The launch file starts watcher, driver and guard, once each, in the namespace /shuttle."""
    require_alive(runs[LAUNCH])
    for recording, case in runs.cases("nodes"):
        _require(recording, case, "the graph has other nodes", _who_is_there)


@check(points=15, asks=WIRING, task=2, scenarios=(LAUNCH,), needs=(), hint="2.1")
def test_connected(runs: Runs) -> None:
    """Each node finds its topics: /scan, distance, cmd_vel_raw, /cmd_vel."""
    wired(runs, *(node.removeprefix("/") for node in NODES))


@check(points=10, asks=SAFETY, task=2, scenarios=(LAUNCH, BENCH), needs=(), hint="2.2")
def test_only_guard(runs: Runs) -> None:
    """Only the guard publishes on /cmd_vel."""
    help = "Who else ends up on /cmd_vel, and by what: a remapping, or a program of its own?"
    require_alive(runs[LAUNCH])
    for recording, case in runs.cases("drivers"):
        _require(recording, case, "not the guard alone publishes on /cmd_vel", lambda _: help)


@check(points=15, asks=DECISION, task=3, scenarios=(LAUNCH,), needs=(), hint="3.1")
def test_parameters(runs: Runs) -> None:
    """The launch file sets the three parameters, each of its own node."""
    require_alive(runs[LAUNCH])
    for recording, case in runs.cases("given"):
        what = f"the launch file does not give the {_owner(case.what)} its {case.what}"
        _require(recording, case, what, _which_parameter)
    for note in runs[LAUNCH].notes:
        if note.kind == "sim_time" and not note.more:
            fail(
                f"{note.about} has use_sim_time, and nothing publishes /clock",
                help="On a robot its time stands at 0 then, and no timer fires. Leave it out.",
                recording=runs[LAUNCH],
            )


@check(points=10, asks=DECISION, task=4, scenarios=(WATCHER,), needs=(), hint="4.1")
def test_distance(runs: Runs) -> None:
    """The watcher tells the distance ahead of each scan, and nothing of a blind one."""
    wired(runs, "shuttle/watcher")
    follows(runs, "distance", topic=DISTANCE)


@check(points=10, asks=DECISION, task=5, scenarios=(DRIVER,), needs=(), hint="5.1")
def test_wishes(runs: Runs) -> None:
    """The driver wants its cruise_speed, and nothing below its stop_distance."""
    wired(runs, "shuttle/driver")
    follows(runs, "wish", topic=RAW, explain=_what_it_wants)


@check(points=10, asks=SAFETY, task=6, scenarios=(GUARD,), needs=(), hint="6.1")
def test_limits(runs: Runs) -> None:
    """The guard passes on 0 to max_speed, and 0 for a wish that is no number."""
    require_alive(runs[0])
    for name, direction in ((CMD_VEL_RAW_TOPIC, "subscribe"), (CMD_VEL_TOPIC, "publish")):
        require_end(runs[0], Topic(name, TWIST, direction))
    follows(runs, "fresh", explain=_what_gets_through)
    zero(runs[0], FIELDS[1:], "Only linear.x is passed on.")


@check(points=10, asks=TIMING, task=6, scenarios=(GUARD,), needs=("limits",), hint="6.2")
def test_silence(runs: Runs) -> None:
    """The guard speaks 20 times a second, and says 0 when the newest wish is 0.5 s old."""
    gaps = np.diff(runs[0].times("/cmd_vel"))
    help = EACH_TICK if len(gaps) and np.median(gaps) < 0.06 else PERIOD
    every(runs[0], "/cmd_vel", 0.05, 0.01, begin=0.2, help=help)
    follows(runs, "old", help="Without a new wish, what does your timer publish?")


@check(
    points=10, asks=SAFETY, scenarios=(WALL, BENCH, LAUNCH), needs=("wishes", "limits"), hint="6.2"
)
def test_keeps_distance(runs: Runs) -> None:
    """The robot drives up to a wall and stops before it; blind, it does not drive."""
    wall = runs.only(WALL)
    keeps_distance(wall)
    if given(runs[LAUNCH]).get("max_speed") == GIVEN["max_speed"]:  # and the guard keeps to it
        for recording in runs.only(BENCH, WALL):
            within(recording, CONTRACT.limits, "What else than the guard's word reaches /cmd_vel?")
    if not any(wall.cases("old")):
        (begin, end), *_ = runs[WALL].scenario.faults.blackout
        fail(
            "wishes came all the while, so the guard never stopped the robot",
            expected=f"no wish while the lidar is silent, from {begin} s to {end} s",
            actual=f"none that was {PATIENCE} s old",
            at=begin + PATIENCE,
            recording=runs[WALL],
            help=CHAIN,
        )
    follows(wall, "old", help=CHAIN)


def _require(
    recording: Recording, case: Case, message: str, explain: Callable[[Case], str]
) -> None:
    """Fail unless the launch file does what it should."""
    if name := case.wrong(TOLERANCE):
        said = case.said.get(name, "its default")
        fail(
            message,
            expected=spell_allowed(case.allowed[name]).strip("“”"),
            actual=f"{said!r}" if case.what in GIVEN and name in case.said else f"{said}",
            at=case.at,
            recording=recording,
            help=explain(case),
        )


def _who_is_there(case: Case) -> str:
    """Say what to look at, where the graph is another one."""
    found = str(case.said["nodes"]).split(", ")
    odd = [each for each in found if " of " in each]
    lost = [node for node in NODES if node not in found]
    if not lost:
        more = [*odd, *(each for each in found if found.count(each) > 1), "more than the three"]
        return f"What makes {more[0]}? Each program starts once, and has one node."
    name, file = lost[0].rpartition("/")[2], NODES[lost[0]]
    if any(each.endswith(f" of {file}") for each in odd):
        return f'It has to be {lost[0]}: namespace="shuttle", and name="{name}" if any.'
    return (
        f'Is there a Node(…) with executable="{name}", of the package "course_exercises", in the '
        "namespace shuttle? Of another package nothing is started here."
    )


def _owner(parameter: str) -> str:
    return "guard" if parameter == "max_speed" else "driver"


def _which_parameter(case: Case) -> str:
    """Say what to look at, where a parameter did not arrive as it should."""
    name, said = case.what, case.said.get(case.what)
    node = _owner(name)
    if said is None:
        return (
            f"Does the {node}'s Node(…) have it in parameters=[{{…}}], spelled {name}? In a YAML "
            f"file it stands below /shuttle/{node}: and ros__parameters:, and the file is named."
        )
    if isinstance(said, str):
        return f"Quotes make a text of it, and the {node} wants a number: write {said}."
    return "The task has the values."


def _what_gets_through(case: Case) -> str:
    """Say what to look at, where the guard's answer to a fresh wish is another one."""
    if case.said.get("linear.x") == 0.0:
        return (
            "Why 0.0? Log the age (`.nanoseconds / 1e9` are seconds), and what min and max make "
            "of the wish."
        )
    return "min, max, and math.isfinite."


def _what_it_wants(case: Case) -> str:
    """Say what to look at, where a wish is another one."""
    if not case.allowed:
        return "No distance, no wish: what publishes by itself makes the guard's patience useless."
    if case.count > 1:
        return "One Twist for each distance: what publishes a second time?"
    return "It ran with cruise_speed 0.45 and stop_distance 0.75, which itself is far enough."
