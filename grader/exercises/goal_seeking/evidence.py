"""What the node did on the way to each goal, and the verdicts that several checks share."""

from __future__ import annotations

import math
from typing import NoReturn

import numpy as np

from grader.checks.commands import is_zero
from grader.checks.verdict import fail
from grader.checks.wiring import require_alive
from grader.exercises.goal_seeking.contract import (
    HAIR,
    PERIOD,
    TOLERANCE,
    Frame,
    Pose,
    Quest,
    arrival,
    poses,
    quests,
)
from grader.recording import Floats, Recording

RATE_TOLERANCE = 0.005  # [s] around the period
AT_ONCE = 0.3  # [s] in which the node warns of what it ignores
REACHED = "goal reached"  # in the log, in any case
REACTION = 2.5 * PERIOD  # [s] long enough for a tick of the control loop, even at 5 Hz


def zero_commands(recording: Recording) -> np.ndarray:
    """Return which commands are zero in every field, (n,) bool."""
    zero: np.ndarray = np.all(is_zero(recording.twists().values), axis=1)
    return zero


def command_times(recording: Recording, begin: float, end: float) -> Floats:
    """Return when commands came in [begin, end) [s], (n,)."""
    t = recording.twists().t
    times: Floats = t[(t >= begin) & (t < end)]
    return times


def stop_times(recording: Recording, quest: Quest) -> Floats:
    """Return when zero Twists came on the way to a goal or after it [s], (n,).

    Zeros from before the first command that moves the robot do not count.
    """
    twists, zero = recording.twists(), zero_commands(recording)
    during = (twists.t >= quest.begin) & (twists.t < quest.end)
    moving = twists.t[during & ~zero]
    stops: Floats = twists.t[during & zero]
    return stops[stops >= moving[0]] if len(moving) else stops


def holds(recording: Recording, frame: Frame = Frame.ODOM) -> list[tuple[Pose, Quest, float]]:
    """Return each pose on the way that held long enough for a command, its goal, and until when.

    The way ends with the arrival: from then on nothing is to be said [s].
    """
    told, goals = poses(recording), quests(recording, frame)
    arrived = {quest: arrival(recording, quest) for quest in goals}
    ends = [pose.t for pose in told[1:]] + [recording.duration_s]
    found = []
    for pose, end in zip(told, ends, strict=False):
        newest = [quest for quest in goals if quest.begin <= pose.t]
        until = min([end, *(quest.begin for quest in goals if quest.begin > pose.t)])
        there = arrived[newest[-1]] if newest else None
        if newest and until - pose.t > REACTION and (there is None or pose.t < there):
            found.append((pose, newest[-1], until))
    return found


def quest_at(recording: Recording, time: float, frame: Frame = Frame.ODOM) -> Quest | None:
    """Return the newest goal at a time [s]."""
    found = [quest for quest in quests(recording, frame) if quest.begin <= time]
    return found[-1] if found else None


def last_command(
    recording: Recording, begin: float, end: float
) -> tuple[float, float, float] | None:
    """Return time [s], linear.x and angular.z of the last command in [begin, end), if any."""
    twists = recording.twists()
    inside = np.flatnonzero((twists.t >= begin) & (twists.t < end))
    if not len(inside):
        return None
    i = inside[-1]
    return float(twists.t[i]), float(twists.linear_x[i]), float(twists.angular_z[i])


def speeds_text(speed: float, turn_rate: float) -> str:
    """Return both fields of a command as a student should see them."""
    return f"linear.x = {speed:.2f} m/s, angular.z = {turn_rate:.2f} rad/s"


def require_silence(recording: Recording, begin: float, end: float, why: str) -> None:
    """Fail if a command came in [begin, end)."""
    times = command_times(recording, begin, end)
    if len(times):
        fail(
            f"{len(times)} command{'s' * (len(times) > 1)} came {why}",
            expected="silence on /cmd_vel",
            actual=f"a Twist at {times[0]:.2f} s",
            at=float(times[0]),
            recording=recording,
            help="Publish nothing, not even zeros, while there is nothing to do.",
        )


def require_one_stop(recording: Recording, quest: Quest) -> None:
    """Fail unless exactly one zero Twist followed the arrival, and then silence."""
    require_alive(recording)
    known_at = arrival(recording, quest)
    if known_at is None:
        fail(
            f"the robot never arrived at {quest.what}, so it could not stop there",
            expected=f"arrival within {TOLERANCE} m",
            actual="never within the tolerance",
            at=quest.end,
            recording=recording,
            help="First get reaches_goal and turns_short_way right, then the stop.",
        )
    zeros = stop_times(recording, quest)
    if not len(zeros) or zeros[0] > known_at + REACTION:
        came = f"the first one at {zeros[0]:.2f} s" if len(zeros) else "none"
        if last := last_command(recording, known_at, known_at + REACTION):
            came += f"; at {last[0]:.2f} s {speeds_text(*last[1:])}"
        fail(
            f"no zero Twist when the robot was within {TOLERANCE} m of {quest.what}",
            expected=f"one zero Twist at the tick after {known_at:.2f} s",
            actual=came,
            at=known_at,
            recording=recording,
            help="On the tick of arrival a zero Twist takes the place of the command.",
        )
    if zeros[0] < known_at and not _nearly_there(recording, quest, float(zeros[0])):
        fail(
            f"a zero Twist came before the robot was within {TOLERANCE} m of {quest.what}",
            expected=f"the stop after {known_at:.2f} s",
            actual=f"at {zeros[0]:.2f} s",
            at=float(zeros[0]),
            recording=recording,
            help="Arrived means: distance to the goal at most 0.5 m.",
        )
    after = command_times(recording, float(zeros[0]), quest.end)
    if len(after) > 1:
        fail(
            f"{len(after) - 1} more command{'s' * (len(after) > 2)} came after the stop at "
            f"{quest.what}",
            expected="exactly one zero Twist, then silence until the next goal",
            actual=f"a further Twist at {after[1]:.2f} s",
            at=float(after[1]),
            recording=recording,
            help="On arrival forget the goal; without a goal publish nothing, wherever you are.",
        )


def require_announcement(recording: Recording, quest: Quest) -> None:
    """Fail unless the log says that a goal is reached, while it is the newest one."""
    if is_announced(recording, quest):
        return
    said = any(REACHED in line.text.lower() for line in recording.log)
    fail(
        f"the log does not say that {quest.what} is reached",
        expected="the line “Goal reached!”, at each arrival",
        actual="none on arrival" if said else "none",
        at=arrival(recording, quest),
        recording=recording,
        help='self.get_logger().info("Goal reached!"), together with the zero Twist.',
    )


def is_announced(recording: Recording, quest: Quest) -> bool:
    """Tell whether the log says that a goal is reached, while it is the newest one."""
    return any(
        quest.begin <= line.t < quest.end + recording.slack
        for line in recording.log
        if REACHED in line.text.lower()
    )


def bad_input(recording: Recording) -> dict[str, Floats]:
    """Return when goals and poses came that are not finite [s], each (n,)."""
    goals, odom = recording.goals(), recording.odometry()
    return {
        "goal": goals.t[~(np.isfinite(goals.x) & np.isfinite(goals.y))],
        "pose": odom.t[~(np.isfinite(odom.x) & np.isfinite(odom.y) & np.isfinite(odom.yaw))],
    }


def require_warnings(recording: Recording) -> None:
    """Fail unless the node warned of goals that are not finite, and of poses."""
    loud = [line.t for line in recording.log if line.level in ("warn", "error", "fatal")]
    for what, times in bad_input(recording).items():
        waited = AT_ONCE + recording.slack
        if not any(time <= t <= time + waited for time in times.tolist() for t in loud):
            fail(
                f"the log has no warning of a {what} that is not finite",
                expected="a warning when it is ignored",
                actual="none",
                at=float(times[0]),
                recording=recording,
                help="self.get_logger().warning(…): whoever sent it has to hear of it.",
            )


def _nearly_there(recording: Recording, quest: Quest, time: float) -> bool:
    """Tell whether the pose known at a time was within the tolerance and a hair."""
    known = [pose for pose in poses(recording) if pose.t <= time]
    return bool(known) and quest.distance(known[-1]) <= TOLERANCE + HAIR


def way(recording: Recording, quest: Quest) -> Floats:
    """Return when commands came on the way to a goal [s], (n,), the stop included.

    The way begins with the first command that moves the robot and ends with the next zero Twist.
    """
    twists, zero = recording.twists(), zero_commands(recording)
    during = (twists.t >= quest.begin) & (twists.t < quest.end)
    moving = twists.t[during & ~zero]
    begin = float(moving[0]) if len(moving) else quest.begin
    stops = twists.t[during & zero & (twists.t >= begin)]
    end = float(stops[0]) + 1e-9 if len(stops) else quest.end
    return command_times(recording, begin, end)


def require_rate(recording: Recording, quest: Quest) -> None:
    """Fail unless commands came every 0.1 s ± 5 ms on the way to a goal."""
    times = way(recording, quest)
    gaps = np.diff(times)
    if len(times) < 3:
        every = len(command_times(recording, quest.begin, quest.end))
        fail(
            f"only {len(times)} commands came on the way to {quest.what}",
            expected=f"one Twist every {PERIOD} s",
            actual=f"{len(times)} in {quest.end - quest.begin:.1f} s"
            if every == len(times)
            else f"{every} in {quest.end - quest.begin:.1f} s, but a zero Twist ends the way",
            at=quest.begin,
            recording=recording,
            help="A timer of 0.1 s has to publish at each tick while there is a goal."
            if every == len(times)
            else "On the way no Twist is zero: linear.x = min(0.3, 0.5 * distance).",
        )
    tolerance = RATE_TOLERANCE + recording.slack
    wrong = np.flatnonzero(np.abs(gaps - PERIOD) > tolerance + 1e-6)
    if len(wrong):
        i = int(wrong[0])
        fail(
            f"the commands on the way to {quest.what} do not come at 10 Hz",
            expected=f"{PERIOD:.3f} s ± {1000 * tolerance:.0f} ms from one to the next",
            actual=f"{gaps[i]:.3f} s ({len(wrong)} of {len(gaps)} gaps are wrong)",
            at=float(times[i + 1]),
            recording=recording,
            help="Publish once in each tick of one 0.1 s timer, and nowhere else.",
        )


def require_no_pause(recording: Recording) -> None:
    """Fail if a new goal, on the way to another one, holds up the commands."""
    t, limit = recording.twists().t, PERIOD + RATE_TOLERANCE + recording.slack + 1e-6
    for quest in quests(recording)[1:]:
        before, after = t[t < quest.begin][-2:], t[t >= quest.begin][:1]
        if len(before) < 2 or not len(after) or quest.begin - before[0] > 2 * limit:
            continue
        if after[0] < quest.begin + REACTION and after[0] - before[1] > limit:
            fail(
                f"the commands pause when {quest.what} comes",
                expected=f"one Twist every {PERIOD} s, whatever comes",
                actual=f"{after[0] - before[1]:.3f} s without one",
                at=float(after[0]),
                recording=recording,
                help="Keep the goal, and let the timer go on as it is.",
            )


def garbage(value: float) -> str:
    """Return an explanation if a number can only be a wrongly typed field; else an empty text."""
    if math.isnan(value) or 0.0 < abs(value) < 1e-300 or 1e6 < abs(value) < math.inf:
        return (
            "This number is garbage: the field may hold an int or a np.float32 where ROS wants a "
            "Python float (write float(…) around it), or NaN came into the computation."
        )
    return ""


def require_holds(
    recording: Recording, frame: Frame = Frame.ODOM, until: float = math.inf
) -> list[tuple[Pose, Quest, tuple[float, float, float]]]:
    """Return pose and goal of each of the `holds`, and its last command (see `last_command`).

    Fail if there is none (by `until` [s]), or if a command is missing.
    """
    found = [hold for hold in holds(recording, frame) if hold[0].t < until]
    if not found:
        fail("the scenario ended before the node was told a pose and a goal", recording=recording)
    said = []
    for pose, quest, end in found:
        command = last_command(recording, pose.t, end)
        if command is None:
            fail_mute(recording, pose.t)
        said.append((pose, quest, command))
    return said


def falls_silent(recording: Recording, time: float) -> bool:
    """Tell whether commands came every 0.1 s before a time [s], and none for a while after it."""
    t, span = recording.twists().t, REACTION + recording.slack
    before = (t >= time - span) & (t < time)
    after = (t >= time + PERIOD / 2) & (t < time + span)
    return before.sum() > 1 and not after.any()


def fail_mute(recording: Recording, time: float, help: str = "") -> NoReturn:
    """Fail a node that says nothing where it should."""
    fail(
        "no command came while the node had a pose and a goal",
        expected="one Twist every 0.1 s",
        actual="silence on /cmd_vel",
        at=time,
        recording=recording,
        help=help or "The timer has to publish at each tick, whether or not something new arrived.",
    )
