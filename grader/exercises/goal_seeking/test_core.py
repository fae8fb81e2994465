"""The core checks of exercise 3; they sum to 100 points."""

from __future__ import annotations

from grader.checks.case import Runs
from grader.checks.check import DECISION, SAFETY, STATE, TIMING, WIRING, check
from grader.checks.commands import FIELDS, ZERO
from grader.checks.verbs import follows, wired, within, zero
from grader.checks.verdict import fail
from grader.exercises.goal_seeking.contract import CONTRACT, MAX_SPEED, SPEED_GAIN, quests
from grader.exercises.goal_seeking.ways import announces, keeps_time, reaches, sent, warns

FIRST = "goal_origin_to_5_3"
AROUND = ("goal_behind", "goal_beside", "goal_across_the_seam")
FAR = "goal_far"
TURNS = "goal_turns"
PATIENCE = 30.0  # [s] for the first goal
CLICK = 1.0  # [s] a goal that counts for less than this cannot be reached
SPEED_TOLERANCE = 0.005  # [m/s]
LEAST_SPL = 0.7  # success weighted by path length (Anderson et al., 2018)


@check(points=5, asks=WIRING, task=1, scenarios=(FIRST,), needs=())
def test_wiring(runs: Runs) -> None:
    """The node starts, spins, listens to /odom and /goal_pose and publishes on /cmd_vel."""
    wired(runs)


@check(points=5, asks=STATE, task=4, scenarios=(FIRST, "goal_without_pose"), hint="2.1")
def test_silent_until_ready(runs: Runs) -> None:
    """Nothing on /cmd_vel until the node has both a pose and a goal; then commands come."""
    follows(runs, "before", help="Publish nothing, not even zeros, while there is nothing to do.")
    follows(runs, "ready")


@check(points=10, asks=TIMING, task=4, scenarios=(FIRST, "goal_changes"), hint="1.2")
def test_control_rate(runs: Runs) -> None:
    """On the way to a goal one command comes every 0.1 s."""
    follows(runs, "ready")
    for recording in runs:
        keeps_time(recording)


@check(points=5, asks=DECISION, task=4, scenarios=(FIRST,), hint="3.1")
def test_reaches_goal(runs: Runs) -> None:
    """From the origin the robot reaches (5, 3) within 30 s."""
    for recording in runs:
        reaches(recording, sent(recording)[0], PATIENCE)


@check(points=5, asks=DECISION, task=4, scenarios=(*AROUND, FAR), hint="3.1")
def test_reaches_any_goal(runs: Runs) -> None:
    """The robot reaches goals behind it, beside it, across the ±π seam, and far away."""
    for recording in runs:
        reaches(recording, sent(recording)[0])


@check(points=10, asks=DECISION, task=3, scenarios=(TURNS,), hint="3.2")
def test_turns_short_way(runs: Runs) -> None:
    """The robot turns toward the goal the short way, across the ±π seam too."""
    help = (
        "A positive angular.z turns left. Wrap bearing minus yaw to [-π, π], for example with "
        "math.remainder(error, math.tau)."
    )
    follows(runs, "turn", help=help)


@check(points=10, asks=DECISION, task=4, scenarios=("goal_speeds", FIRST), hint="4.2")
def test_speed_law(runs: Runs) -> None:
    """linear.x = min(0.3, 0.5 · distance) [m/s]; slower only while it turns."""
    help = f"linear.x = min({MAX_SPEED}, {SPEED_GAIN} * distance), to the newest goal"
    follows(runs, "speed", help=help, tolerance=SPEED_TOLERANCE)


@check(points=5, asks=SAFETY, task=4, scenarios=(FIRST, *AROUND, TURNS), hint="4.2")
def test_limits(runs: Runs) -> None:
    """Never faster than 0.3 m/s or 1.9 rad/s, never backwards; every other field is zero."""
    follows(runs, "ready")
    for recording in runs:
        within(recording, CONTRACT.limits, help="Clamp: max(least, min(most, value)).")
        zero(recording, FIELDS[1:5], help="This robot drives ahead, and turns.")


@check(points=10, asks=STATE, task=5, scenarios=("goal_arrival", "goal_carried"), hint="5.2")
def test_stops_once(runs: Runs) -> None:
    """On arrival one zero Twist and “Goal reached!” in the log, then silence, wherever it is."""
    help = "On arrival one zero Twist takes the place of the command; forget the goal then."
    follows(runs, "stop", help=help, tolerance=ZERO)
    for recording in runs:
        announces(recording, sent(recording)[-1])


@check(
    points=10,
    asks=STATE,
    task=5,
    scenarios=("goal_changes", "goal_clicks", FAR),
    needs=("wiring", "reaches_goal"),
    hint="5.1",
)
def test_new_goal(runs: Runs) -> None:
    """A new goal starts over: on the way to another, long after arrival, a hundred in a row."""
    for recording in runs:
        for quest in quests(recording)[1:]:
            if quest.end - quest.begin > CLICK:
                reaches(recording, quest)


@check(points=10, asks=STATE, task=5, scenarios=("goal_near",), hint="5.3")
def test_near_goal(runs: Runs) -> None:
    """A goal already within 0.5 m is reached at the next tick; sent again, it counts again."""
    help = "Treat every goal alike: the control loop finds that it is reached."
    follows(runs, "there", help=help, tolerance=ZERO)
    for recording in runs:
        for quest in quests(recording):
            announces(recording, quest)


@check(points=5, asks=SAFETY, task=4, scenarios=("goal_bad_input",), hint="2.2")
def test_bad_input(runs: Runs) -> None:
    """Goals and poses that are not finite are ignored, and the node goes on."""
    help = "Test x, y and yaw with math.isfinite before you keep them, each as it comes."
    follows(runs, "ready", "bad", help=help, tolerance=SPEED_TOLERANCE)


@check(points=5, asks=DECISION, task=2, scenarios=("goal_bad_input",), hint="2.2")
def test_warns(runs: Runs) -> None:
    """The log has a warning of a goal that is not finite, and of a pose."""
    warns(runs[0])


@check(
    points=5,
    asks=DECISION,
    task=4,
    scenarios=(FIRST, *AROUND),
    needs=("reaches_goal", "reaches_any_goal"),
    hint="4.3",
)
def test_path_efficiency(runs: Runs) -> None:
    """The robot does not wander: its paths are short (SPL of at least 0.7)."""
    ratios = [reaches(recording, sent(recording)[0]) for recording in runs]
    spl = sum(ratios) / len(ratios)
    if spl < LEAST_SPL:
        worst = runs[ratios.index(min(ratios))]
        fail(
            "the robot takes long detours",
            expected=f"SPL (shortest path / path, on average) of at least {LEAST_SPL}",
            actual=f"{spl:.2f}: " + ", ".join(f"{ratio:.2f}" for ratio in ratios),
            recording=worst,
            at=sent(worst)[0].begin,
            help="Turn faster at the beginning (a higher gain), or slow down while you turn.",
        )
