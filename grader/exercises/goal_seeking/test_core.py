"""The core checks of exercise 3; they sum to 100 points."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import NoReturn

import numpy as np
import pytest

from grader.checks.commands import FIELDS, ZERO
from grader.checks.moments import first_asked
from grader.checks.verdict import fail
from grader.checks.wiring import require_alive, require_wiring
from grader.exercises.goal_seeking.contract import (
    MAX_SPEED,
    MAX_TURN_RATE,
    TOLERANCE,
    Frame,
    arrival,
    quests,
    ready_at,
)
from grader.exercises.goal_seeking.evidence import (
    REACTION,
    bad_input,
    command_times,
    fail_mute,
    falls_silent,
    garbage,
    is_announced,
    last_command,
    require_announcement,
    require_no_pause,
    require_one_stop,
    require_rate,
    require_silence,
    require_warnings,
    speeds_text,
    way,
    zero_commands,
)
from grader.exercises.goal_seeking.habits import (
    ARRIVAL,
    NEAR,
    TURNS,
    deaf_from,
    frame_of,
    tolerance_of,
    turns_in_garbage,
)
from grader.exercises.goal_seeking.reaching import (
    path_ratio,
    reached,
    require_heard,
    require_on_the_way,
    require_reached,
)
from grader.exercises.goal_seeking.speeds import LAW_TOLERANCE, require_no_faster, require_speeds
from grader.exercises.goal_seeking.turning import require_turns, require_turns_toward
from grader.recording import Recording

FIRST = "goal_origin_to_5_3"
AROUND = ("goal_behind", "goal_beside", "goal_across_the_seam")
FAR = "goal_far"
PATIENCE = 30.0  # [s] for the first goal
CLICK = 1.0  # [s] a goal that counts for less than this cannot be reached
LOST = "A bad goal came 5 ms after the good one: check each as it comes, and keep the good one."
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
        require_no_pause(recording)


@pytest.mark.check(points=5, scenarios=(FIRST, ARRIVAL), needs=("wiring",))
def test_reaches_goal(recordings: Recordings) -> None:
    """From the origin the robot reaches (5, 3) within 30 s."""
    *drives, push = recordings
    for recording in drives:
        require_alive(recording)
        for quest in quests(recording):
            require_reached(recording, quest, PATIENCE, tolerance_of(push))


@pytest.mark.check(points=5, scenarios=(*AROUND, FAR, ARRIVAL), needs=("wiring",))
def test_reaches_any_goal(recordings: Recordings) -> None:
    """The robot reaches goals behind it, beside it, across the ±π seam, and far away."""
    *drives, push = recordings
    for recording in drives:
        require_alive(recording)
        require_reached(recording, quests(recording)[0], tolerance=tolerance_of(push))


@pytest.mark.check(points=10, scenarios=(*AROUND, TURNS), needs=("wiring",))
def test_turns_short_way(recordings: Recordings) -> None:
    """The robot turns toward the goal the short way, across the ±π seam too."""
    *drives, bench = recordings
    for recording in drives:
        require_alive(recording)
        require_turns_toward(recording, quests(recording)[0])
    require_turns(bench)


@pytest.mark.check(points=10, scenarios=("goal_speeds", FIRST, TURNS, NEAR, FAR), needs=("wiring",))
def test_speed_law(recordings: Recordings) -> None:
    """linear.x = min(0.3, 0.5 · distance) [m/s]; slower only while it turns."""
    bench, drive, turns, near, far = recordings
    frame = frame_of(turns)
    # Who gives a far goal up has lost the points for that.
    patient = all(reached(far, quest) for quest in quests(far)[:1])
    last_two = [quest.begin for quest in quests(bench)[-2:]]  # very far, and never reached
    until = math.inf if patient else min(last_two, default=math.inf)
    require_speeds(bench, frame, min(until, deaf_from(near, bench)))
    require_no_faster(drive, frame)


@pytest.mark.check(points=5, scenarios=(FIRST, *AROUND, TURNS), needs=("wiring",))
def test_limits(recordings: Recordings) -> None:
    """Never faster than 0.3 m/s or 1.9 rad/s, never backwards; every other field is zero."""
    limits = {0: MAX_SPEED, 5: MAX_TURN_RATE}
    unread = turns_in_garbage(recordings[-1])
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
            named = [unread and column == 5 and bool(garbage(number)) for number in numbers]
            wrong = np.flatnonzero((~within | strange) & ~np.array(named))
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
        backwards = np.flatnonzero(twists.linear_x < -ZERO)
        if len(backwards):
            fail(
                "the robot drives backwards",
                expected=f"0.0 ≤ linear.x ≤ {MAX_SPEED}",
                actual=f"linear.x = {twists.linear_x[backwards[0]]:.3f} m/s",
                at=float(twists.t[backwards[0]]),
                recording=recording,
                help="Slower while it turns is allowed: max(0.0, …). Nothing looks behind it.",
            )


@pytest.mark.check(points=10, scenarios=(ARRIVAL, "goal_carried", TURNS), needs=("wiring",))
def test_stops_once(recordings: Recordings) -> None:
    """On arrival one zero Twist and “Goal reached!” in the log, then silence, wherever it is."""
    *pushes, turns = recordings
    for recording in pushes:
        require_alive(recording)
        quest = quests(recording, frame_of(turns))[-1]  # the one before is the same, on the way
        require_one_stop(recording, quest)
        require_announcement(recording, quest)


@pytest.mark.check(
    points=10,
    scenarios=("goal_changes", "goal_clicks", FAR, TURNS, FIRST, *AROUND),
    needs=("wiring",),
)
def test_new_goal(recordings: Recordings) -> None:
    """A new goal starts over: on the way to another, long after arrival, a hundred in a row."""
    changes, clicks, far, turns, *drives = recordings
    frame = frame_of(turns)
    # Who finds no way to a single goal has lost the points for that.
    finds_them = all(reached(r, quest) for r in drives for quest in quests(r))
    require = require_reached if finds_them else require_heard
    # Who is not there when the next goal comes has a longer way to that.
    there = finds_them and any(reached(far, quest) for quest in quests(far)[:1])
    for recording in (changes, clicks, *[far] * there):
        require_alive(recording)
        for quest in quests(recording, frame)[1:]:
            if quest.end - quest.begin > CLICK:
                (require if frame is Frame.ODOM else require_on_the_way)(recording, quest)


@pytest.mark.check(points=10, scenarios=(NEAR, ARRIVAL), needs=("wiring",))
def test_near_goal(recordings: Recordings) -> None:
    """A goal already within 0.5 m is reached at the next tick; sent again, it counts again."""
    recording, push = recordings
    require_alive(recording)
    twists, zero = recording.twists(), zero_commands(recording)
    for number, quest in enumerate(quests(recording)):
        again = " (the same goal again)" if number == 1 else ""
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
                f"the robot moves, though {quest.what} is nearer than {TOLERANCE} m{again}",
                expected="one zero Twist at the next tick",
                actual=speeds_text(twists.linear_x[moving], twists.angular_z[moving]),
                at=float(twists.t[moving]),
                recording=recording,
                help="Compare the distance with 0.5 m before you compute a command.",
            )
    said = [is_announced(recording, quest) for quest in quests(recording)[:1]]
    said += [is_announced(push, quest) for quest in quests(push)[-1:]]
    if any(said):
        for quest in quests(recording):  # else stops_once says that none ever is
            require_announcement(recording, quest)


@pytest.mark.check(points=10, scenarios=("goal_bad_input", TURNS), needs=("wiring",))
def test_bad_input(recordings: Recordings) -> None:
    """Goals and poses that are not finite are ignored, with a warning, and the node goes on."""
    *told, turns = recordings
    unread = turns_in_garbage(turns)
    for recording in told:
        require_alive(recording)
        twists = recording.twists()
        early = np.flatnonzero((twists.t < ready_at(recording)) & ~zero_commands(recording))
        if len(early):
            _fail_bad_input(recording, int(early[0]), "nothing: the only goal was not finite")
        bad = np.sort(np.concatenate(list(bad_input(recording).values()))).tolist()
        begin, goal = ready_at(recording), quests(recording)[-1]
        end = arrival(recording, goal) or recording.duration_s
        first = next(time for time in bad if time > begin + REACTION)
        before = last_command(recording, begin, first)
        if before is None:
            fail_mute(recording, begin, LOST)
        _, v, w = before  # the robot faces its goal: nothing may change now
        for start, stop in pairwise([time for time in bad if first <= time < end] + [end]):
            during = np.flatnonzero((twists.t >= start) & (twists.t < stop))
            if not len(during) or falls_silent(recording, start):
                fail_mute(recording, start)
            with np.errstate(invalid="ignore", over="ignore"):  # inf - inf is not the same, either
                same = np.abs(twists.linear_x[during] - v) <= LAW_TOLERANCE
                if not (unread and garbage(w)):
                    same &= np.abs(twists.angular_z[during] - w) <= 0.1
            if not same.all():
                wrong = int(during[np.flatnonzero(~same)[0]])
                _fail_bad_input(recording, wrong, f"as before: {v:.2f} m/s, {w:.2f} rad/s")
        _require_rest(recording, bad[-1])
        require_warnings(recording)


@pytest.mark.check(
    points=5, scenarios=(FIRST, *AROUND, ARRIVAL), needs=("reaches_goal", "reaches_any_goal")
)
def test_path_efficiency(recordings: Recordings) -> None:
    """The robot does not wander: its paths are short (SPL of at least 0.7)."""
    *drives, push = recordings
    for recording in drives:
        require_alive(recording)
    ratios = [path_ratio(recording, tolerance_of(push)) for recording in drives]
    spl = sum(ratios) / len(ratios)
    if spl < LEAST_SPL:
        worst = int(np.argmin(ratios))
        fail(
            "the robot takes long detours",
            expected=f"SPL (shortest path / path, on average) of at least {LEAST_SPL}",
            actual=f"{spl:.2f}: " + ", ".join(f"{ratio:.2f}" for ratio in ratios),
            recording=drives[worst],
            at=quests(drives[worst])[0].begin,
            help="Turn faster at the beginning (a higher gain), or slow down while you turn.",
        )


def _require_rest(recording: Recording, time: float) -> None:
    """Fail if a bad goal sets a robot in motion that was silent until then, having arrived."""
    times = command_times(recording, time - REACTION, recording.duration_s)
    woken = times[times >= time]
    if len(woken) == len(times) > 0:
        index = int(np.flatnonzero(recording.twists().t == woken[0])[0])
        _fail_bad_input(recording, index, "silence: it has arrived, and no goal came since")


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
