"""The core checks of exercise 3; they sum to 100 points."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import NoReturn

import numpy as np
import pytest

from grader.checks.commands import FIELDS, ZERO
from grader.checks.goal_seeking.contract import (
    MAX_SPEED,
    MAX_TURN_RATE,
    TOLERANCE,
    poses,
    quests,
    ready_at,
    speed_law,
)
from grader.checks.goal_seeking.evidence import (
    REACTION,
    command_times,
    garbage,
    holds,
    last_command,
    quest_at,
    reached,
    require_announcement,
    require_heard,
    require_one_stop,
    require_rate,
    require_reached,
    require_sign,
    require_silence,
    require_turns_toward,
    require_warnings,
    way,
    zero_commands,
)
from grader.checks.moments import first_asked
from grader.checks.verdict import fail
from grader.checks.wiring import require_alive, require_wiring
from grader.recording import Recording

FIRST = "goal_origin_to_5_3"
AROUND = ("goal_behind", "goal_beside", "goal_across_the_seam")
PATIENCE = 30.0  # [s] for the first goal
LAW_TOLERANCE = 0.005  # [m/s]
CLICK = 1.0  # [s] a goal that counts for less than this cannot be reached
LEAST_SPL = 0.7  # success weighted by path length (Anderson et al., 2018)

Recordings = tuple[Recording, ...]


@pytest.mark.check(points=5, scenarios=(FIRST,))
def test_wiring(recordings: Recordings) -> None:
    """The node starts, spins, listens to /odom and /goal_pose and publishes on /cmd_vel."""
    for recording in recordings:
        require_wiring(recording, "goal_seeking")


@pytest.mark.check(points=5, scenarios=(FIRST, "goal_without_pose"), needs=("wiring",))
def test_silent_until_ready(recordings: Recordings) -> None:
    """Nothing on /cmd_vel until the node has both a pose and a goal; then commands come."""
    for recording in recordings:
        require_alive(recording)
        ready = ready_at(recording)
        require_silence(recording, 0.0, ready, "before the node had both a pose and a goal")
        if not len(command_times(recording, ready, recording.duration_s)):
            fail(
                "the node stays silent, though it has a pose and a goal",
                expected=f"commands from {ready:.2f} s on",
                actual="nothing on /cmd_vel",
                at=ready,
                recording=recording,
                help="Does the timer's callback run, and does it see the pose and the goal?",
            )


@pytest.mark.check(points=10, scenarios=(FIRST, "goal_changes"), needs=("wiring",))
def test_control_rate(recordings: Recordings) -> None:
    """On the way to a goal one command comes every 0.1 s."""
    for recording in recordings:
        require_alive(recording)
        answered = [q for q in quests(recording) if len(command_times(recording, q.begin, q.end))]
        for number, quest in enumerate(answered or quests(recording)):
            if number == 0 or len(way(recording, quest)) > 2:
                require_rate(recording, quest)


@pytest.mark.check(points=5, scenarios=(FIRST,), needs=("wiring",))
def test_reaches_goal(recordings: Recordings) -> None:
    """From the origin the robot reaches (5, 3) within 30 s."""
    for recording in recordings:
        require_alive(recording)
        for quest in quests(recording):
            require_reached(recording, quest, PATIENCE)


@pytest.mark.check(points=5, scenarios=AROUND, needs=("wiring",))
def test_reaches_any_goal(recordings: Recordings) -> None:
    """The robot reaches goals behind it, beside it and across the ±π seam."""
    for recording in recordings:
        require_alive(recording)
        for quest in quests(recording):
            require_reached(recording, quest)


@pytest.mark.check(points=10, scenarios=(*AROUND, "goal_turns"), needs=("wiring",))
def test_turns_short_way(recordings: Recordings) -> None:
    """The robot turns toward the goal the short way, across the ±π seam too."""
    *drives, bench = recordings
    for recording in drives:
        require_alive(recording)
        require_turns_toward(recording, quests(recording)[0])
    require_alive(bench)
    _require_holds(bench)
    for pose, quest, end in holds(bench):
        command = last_command(bench, pose.t, end)
        if command is None:
            _fail_mute(bench, pose.t)
        time, _, turn_rate = command
        require_sign(bench, quest, pose, time, turn_rate)


@pytest.mark.check(points=10, scenarios=("goal_speeds", FIRST), needs=("wiring",))
def test_speed_law(recordings: Recordings) -> None:
    """linear.x = min(0.3, 0.5 · distance) [m/s]; slower only while it turns."""
    bench, drive = recordings
    require_alive(bench)
    _require_holds(bench)
    for pose, quest, end in holds(bench):
        command = last_command(bench, pose.t, end)
        if command is None:
            _fail_mute(bench, pose.t)
        time, speed, _ = command
        _require_law(bench, time, speed, quest.distance(pose), slower=False)
    require_alive(drive)
    known, twists = poses(drive), drive.twists()
    heard = np.array([pose.t for pose in known])
    for time, speed in zip(twists.t.tolist(), twists.linear_x.tolist(), strict=True):
        goal, last = quest_at(drive, time), int(np.searchsorted(heard, time, side="right"))
        if goal is not None and last:
            distance = max(goal.distance(pose) for pose in known[max(0, last - 2) : last])
            _require_law(drive, time, speed, distance, slower=True)


@pytest.mark.check(points=5, scenarios=(FIRST, *AROUND, "goal_turns"), needs=("wiring",))
def test_limits(recordings: Recordings) -> None:
    """Never faster than 0.3 m/s or 1.9 rad/s; every other field is zero."""
    limits = {0: MAX_SPEED, 5: MAX_TURN_RATE}
    for recording in recordings:
        require_alive(recording)
        twists = recording.twists()
        if not len(twists.t):
            fail(
                "not a single Twist came on /cmd_vel",
                at=first_asked(recording),
                recording=recording,
            )
        for column, name in enumerate(FIELDS):
            limit = limits.get(column, 0.0)
            numbers = twists.values[:, column]
            strange = (numbers != 0.0) & (np.abs(numbers) < 1e-300)  # an int's memory as a double
            within = np.abs(numbers) <= limit + ZERO  # never true of NaN
            wrong = np.flatnonzero(~within | strange)
            if len(wrong):
                value = float(numbers[wrong[0]])
                fail(
                    f"{name} is out of its limits",
                    expected=f"|{name}| ≤ {limit}" if limit else f"{name} = 0.0",
                    actual=f"{name} = {value:.3g}",
                    at=float(twists.t[wrong[0]]),
                    recording=recording,
                    help=garbage(value) or "Clamp: max(-limit, min(limit, value)).",
                )


@pytest.mark.check(points=10, scenarios=("goal_arrival",), needs=("wiring",))
def test_stops_once(recordings: Recordings) -> None:
    """On arrival one zero Twist and “Goal reached!” in the log, then silence, wherever it is."""
    for recording in recordings:
        require_alive(recording)
        for quest in quests(recording):
            require_one_stop(recording, quest)
            require_announcement(recording, quest)


@pytest.mark.check(
    points=10, scenarios=("goal_changes", "goal_clicks", FIRST, *AROUND), needs=("wiring",)
)
def test_new_goal(recordings: Recordings) -> None:
    """A new goal starts over: on the way to another, after arrival, a hundred in a row."""
    changes, clicks, *drives = recordings
    # Who finds no way to a single goal has lost the points for that.
    finds_them = all(reached(r, q) is not None for r in drives for q in quests(r))
    for recording in (changes, clicks):
        require_alive(recording)
        for quest in quests(recording)[1:]:
            if quest.end - quest.begin > CLICK:
                (require_reached if finds_them else require_heard)(recording, quest)


@pytest.mark.check(points=10, scenarios=("goal_near",), needs=("wiring",))
def test_near_goal(recordings: Recordings) -> None:
    """A goal already within 0.5 m is reached at the next tick; sent again, it counts again."""
    for recording in recordings:
        require_alive(recording)
        twists, zero = recording.twists(), zero_commands(recording)
        for number, quest in enumerate(quests(recording)):
            again = " (the same goal again)" if number else ""
            during = np.flatnonzero((twists.t >= quest.begin) & (twists.t < quest.end))
            first = float(twists.t[during[0]]) if len(during) else math.inf
            if first > quest.begin + REACTION:
                fail(
                    f"no command for {quest.what}, which is nearer than {TOLERANCE} m{again}",
                    expected="one zero Twist at the next tick",
                    actual=f"a Twist at {first:.2f} s" if len(during) else "nothing on /cmd_vel",
                    at=quest.begin,
                    recording=recording,
                    help="Treat every goal alike: the control loop finds that it is reached.",
                )
            if not zero[during].all():
                moving = during[~zero[during]][0]
                fail(
                    f"the robot drives, though {quest.what} is nearer than {TOLERANCE} m{again}",
                    expected="one zero Twist at the next tick",
                    actual=f"linear.x = {twists.linear_x[moving]:.2f} m/s",
                    at=float(twists.t[moving]),
                    recording=recording,
                    help="Compare the distance with 0.5 m before you compute a command.",
                )


@pytest.mark.check(points=10, scenarios=("goal_bad_input",), needs=("wiring",))
def test_bad_input(recordings: Recordings) -> None:
    """Goals and poses that are not finite are ignored, with a warning, and the node goes on."""
    for recording in recordings:
        require_alive(recording)
        twists = recording.twists()
        early = np.flatnonzero((twists.t < ready_at(recording)) & ~zero_commands(recording))
        if len(early):
            _fail_bad_input(recording, int(early[0]), "nothing: the only goal was not finite")
        bad = _times_of_bad_input(recording)
        begin, end = ready_at(recording), recording.duration_s
        first = next(time for time in bad if time > begin)
        before = last_command(recording, begin, first)
        if before is None:
            _fail_mute(recording, begin)
        _, v, w = before  # the robot faces its goal: nothing may change now
        for start, stop in pairwise([time for time in bad if time >= first] + [end]):
            during = np.flatnonzero((twists.t >= start) & (twists.t < stop))
            if not len(during):
                _fail_mute(recording, start)
            with np.errstate(invalid="ignore"):  # inf - inf is not the same, either
                same = np.abs(twists.linear_x[during] - v) <= LAW_TOLERANCE
                same &= np.abs(twists.angular_z[during] - w) <= 0.1
            if not same.all():
                wrong = int(during[np.flatnonzero(~same)[0]])
                _fail_bad_input(recording, wrong, f"as before: {v:.2f} m/s, {w:.2f} rad/s")
        require_warnings(recording)


@pytest.mark.check(points=5, scenarios=(FIRST, *AROUND), needs=("reaches_goal", "reaches_any_goal"))
def test_path_efficiency(recordings: Recordings) -> None:
    """The robot does not wander: its paths are short (SPL of at least 0.7)."""
    for recording in recordings:
        require_alive(recording)
    ratios = [_path_ratio(recording) for recording in recordings]
    spl = sum(ratios) / len(ratios)
    if spl < LEAST_SPL:
        worst = int(np.argmin(ratios))
        fail(
            "the robot takes long detours",
            expected=f"SPL (shortest path / path, on average) of at least {LEAST_SPL}",
            actual=f"{spl:.2f}: " + ", ".join(f"{ratio:.2f}" for ratio in ratios),
            recording=recordings[worst],
            at=quests(recordings[worst])[0].begin,
            help="Turn faster at the beginning (a higher gain), or slow down while you turn.",
        )


def _times_of_bad_input(recording: Recording) -> list[float]:
    """Return when goals or poses came that are not finite [s]."""
    goals, odom = recording.goals(), recording.odometry()
    bad_goals = goals.t[~(np.isfinite(goals.x) & np.isfinite(goals.y))]
    bad_poses = odom.t[~(np.isfinite(odom.x) & np.isfinite(odom.y) & np.isfinite(odom.yaw))]
    return sorted([*bad_goals.tolist(), *bad_poses.tolist()])


def _fail_bad_input(recording: Recording, index: int, expected: str) -> NoReturn:
    twists = recording.twists()
    v, w = float(twists.linear_x[index]), float(twists.angular_z[index])
    fail(
        "a goal or a pose that is not finite was not ignored",
        expected=expected,
        actual=f"{v:.2f} m/s, {w:.2f} rad/s",
        at=float(twists.t[index]),
        recording=recording,
        help="Test x, y and yaw with math.isfinite before you keep them.",
    )


def _path_ratio(recording: Recording) -> float:
    """Return shortest path / path driven to the goal's circle, 0 if it was not reached."""
    quest, truth = quests(recording)[0], recording.truth
    t = truth.t / 1e9
    during = (t >= quest.begin) & (t <= quest.end)
    x, y = truth.x[during], truth.y[during]
    distance = np.hypot(x - quest.x, y - quest.y)
    near = np.flatnonzero(distance <= TOLERANCE + 0.01)
    if not len(near):
        return 0.0
    steps = np.hypot(np.diff(x), np.diff(y))[: near[0]]
    shortest = float(distance[0] - distance[near[0]])
    return shortest / max(shortest, float(steps.sum()))


def _require_law(
    recording: Recording, time: float, speed: float, distance: float, *, slower: bool
) -> None:
    wanted = speed_law(distance)
    too_slow = not slower and speed < wanted - LAW_TOLERANCE
    within = speed <= wanted + LAW_TOLERANCE  # never true of NaN
    if too_slow or not within:
        fail(
            f"wrong speed at {distance:.2f} m from the goal",
            expected=f"linear.x = min(0.3, 0.5 · {distance:.2f}) = {wanted:.3f} m/s",
            actual=f"linear.x = {speed:.3f} m/s",
            at=time,
            recording=recording,
            help=garbage(speed) or "linear.x = min(0.3, 0.5 * distance)",
        )


def _require_holds(recording: Recording) -> None:
    if not holds(recording):
        fail("the scenario ended before the node was told a pose and a goal", recording=recording)


def _fail_mute(recording: Recording, time: float) -> NoReturn:
    fail(
        "no command came while the node had a pose and a goal",
        expected="one Twist every 0.1 s",
        actual="silence on /cmd_vel",
        at=time,
        recording=recording,
        help="The timer has to publish at each tick, whether or not something new arrived.",
    )
