"""What the node did on the way to each goal, and the verdicts that several checks share."""

from __future__ import annotations

import math

import numpy as np

from grader.checks.commands import is_zero
from grader.checks.goal_seeking.contract import (
    HAIR,
    PERIOD,
    TOLERANCE,
    Pose,
    Quest,
    arrival,
    poses,
    quests,
)
from grader.checks.verdict import fail
from grader.checks.wiring import require_alive
from grader.recording import Floats, Recording

RATE_TOLERANCE = 0.005  # [s] around the period
AT_ONCE = 0.3  # [s] in which the node warns of what it ignores
FACING = 0.3  # [rad] from the goal
STILL = 20  # samples of the robot's pose
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


def holds(recording: Recording) -> list[tuple[Pose, Quest, float]]:
    """Return each pose that held long enough for a command, its goal, and until when [s]."""
    told, goals = poses(recording), quests(recording)
    ends = [pose.t for pose in told[1:]] + [recording.duration_s]
    found = []
    for pose, end in zip(told, ends, strict=False):
        newest = [quest for quest in goals if quest.begin <= pose.t]
        until = min([end, *(quest.begin for quest in goals if quest.begin > pose.t)])
        if newest and until - pose.t > REACTION:
            found.append((pose, newest[-1], until))
    return found


def quest_at(recording: Recording, time: float) -> Quest | None:
    """Return the newest goal at a time [s]."""
    found = [quest for quest in quests(recording) if quest.begin <= time]
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


def carried_at(recording: Recording, quest: Quest) -> float:
    """Return when somebody carries the robot while a goal counts [s]; its end if nobody does."""
    times = [event.at for event in recording.scenario.script if event.teleport is not None]
    return min((time for time in times if quest.begin < time < quest.end), default=quest.end)


def reached(recording: Recording, quest: Quest, within: float = math.inf) -> float | None:
    """Return when the real robot drove to within the tolerance of a goal [s], if it did."""
    truth = recording.truth
    t = truth.t / 1e9
    during = (t >= quest.begin) & (t <= _patience(recording, quest, within))
    distance = np.hypot(truth.x - quest.x, truth.y - quest.y)[during]
    # The robot stops a little late: its pose is up to an odometry message and a tick old.
    near = np.flatnonzero(distance <= TOLERANCE + 0.01)
    return float(t[during][near[0]]) if len(near) else None


def _patience(recording: Recording, quest: Quest, within: float) -> float:
    return min(carried_at(recording, quest), quest.begin + within)


def require_reached(recording: Recording, quest: Quest, within: float = math.inf) -> None:
    """Fail unless the real robot drove to within the tolerance of a goal."""
    truth = recording.truth
    t = truth.t / 1e9
    end = _patience(recording, quest, within)
    during = (t >= quest.begin) & (t <= end)
    if not during.any():
        fail(f"the scenario ended before {quest.what}", recording=recording)
    distance = np.hypot(truth.x - quest.x, truth.y - quest.y)[during]
    if reached(recording, quest, within) is None:
        last = np.flatnonzero(during)[-1]
        off = quest.heading_error(Pose(*(float(a[last]) for a in (t, truth.x, truth.y, truth.yaw))))
        facing, still = abs(off) < FACING, float(np.ptp(distance[-STILL:])) < 1e-3
        fail(
            f"the robot did not reach {quest.what}",
            expected=f"within {TOLERANCE} m after at most {end - quest.begin:.0f} s",
            actual=f"{distance.min():.2f} m at the nearest, {distance[-1]:.2f} m at the end, where "
            f"it looks {abs(off):.1f} rad away from the goal",
            at=float(t[during][int(np.argmin(distance))]),
            recording=recording,
            help="It looks at the goal and stands: is the distance math.hypot(dx, dy), and does it "
            "arrive only within 0.5 m?"
            if facing and still
            else "It turns until it faces the goal, and keeps driving: the heading error is the "
            "bearing to the goal minus the robot's yaw. Watch the replay.",
        )


def require_heard(recording: Recording, quest: Quest) -> None:
    """Fail unless the robot sets out for a goal at once, and stops there when it is carried there.

    That a goal is heard shows, too, in a node that finds the way to none.
    """
    twists, zero = recording.twists(), zero_commands(recording)
    moving = twists.t[~zero & (twists.t >= quest.begin) & (twists.t < quest.end)]
    if not len(moving) or moving[0] > quest.begin + REACTION:
        fail(
            f"the robot does not set out for {quest.what}",
            expected=f"a command that moves it by {quest.begin + REACTION:.2f} s",
            actual=f"the first one at {moving[0]:.2f} s" if len(moving) else "none",
            at=quest.begin,
            recording=recording,
            help="A new goal replaces the old one, whether that is reached or not.",
        )
    there = arrival(recording, quest)
    stops = stop_times(recording, quest)
    if there is None or not len(stops) or stops[0] > there + REACTION:
        fail(
            f"the robot was at {quest.what}, and did not stop",
            expected="a zero Twist at the next tick",
            actual=f"one at {stops[0]:.2f} s" if len(stops) else "none",
            at=carried_at(recording, quest) if there is None else there,
            recording=recording,
            help="A new goal replaces the old one: compare your pose with the newest.",
        )


def require_turns_toward(recording: Recording, quest: Quest) -> None:
    """Fail unless the first turn after a goal has the sign of the heading error."""
    twists = recording.twists()
    during = (twists.t >= quest.begin) & (twists.t < quest.end)
    turning = during & (np.abs(twists.angular_z) > 1e-3)
    if not turning.any():
        fail(
            f"the robot never turned on the way to {quest.what}",
            expected="angular.z toward the goal",
            actual="no command that turns",
            at=quest.begin,
            recording=recording,
            help="angular.z = gain · heading error",
        )
    first = int(np.argmax(turning))
    known = [pose for pose in poses(recording) if pose.t <= twists.t[first]]
    if known:
        require_sign(
            recording, quest, known[-1], float(twists.t[first]), float(twists.angular_z[first])
        )


def require_sign(
    recording: Recording, quest: Quest, pose: Pose, time: float, turn_rate: float
) -> None:
    """Fail if a turn rate [rad/s] leads the long way; near 0 and ±π either way is right."""
    error = quest.heading_error(pose)
    if not 0.2 < abs(error) < math.pi - 0.2:
        return
    if turn_rate * error > 0 and abs(turn_rate) > 1e-3:
        return
    side = "left (positive)" if error > 0 else "right (negative)"
    fail(
        f"the robot does not turn the short way to {quest.what}",
        expected=f"angular.z to the {side}: the heading error is {error:+.2f} rad",
        actual=f"angular.z = {turn_rate:+.2f} rad/s",
        at=time,
        recording=recording,
        help="Wrap bearing minus yaw to [-π, π], for example with math.remainder(error, math.tau).",
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
    said = [line for line in recording.log if REACHED in line.text.lower()]
    if any(quest.begin <= line.t < quest.end + recording.slack for line in said):
        return
    fail(
        f"the log does not say that {quest.what} is reached",
        expected="the line “Goal reached!”",
        actual="none on arrival" if said else "none",
        at=arrival(recording, quest),
        recording=recording,
        help='self.get_logger().info("Goal reached!"), together with the zero Twist.',
    )


def require_warnings(recording: Recording) -> None:
    """Fail unless the node warned of goals that are not finite, and of poses."""
    goals, odom = recording.goals(), recording.odometry()
    bad = {
        "goal": goals.t[~(np.isfinite(goals.x) & np.isfinite(goals.y))],
        "pose": odom.t[~(np.isfinite(odom.x) & np.isfinite(odom.y) & np.isfinite(odom.yaw))],
    }
    loud = [line.t for line in recording.log if line.level in ("warn", "error", "fatal")]
    for what, times in bad.items():
        if not any(times[0] <= t <= times[-1] + AT_ONCE + recording.slack for t in loud):
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
        fail(
            f"only {len(times)} commands came on the way to {quest.what}",
            expected=f"one Twist every {PERIOD} s",
            actual=f"{len(times)} in {quest.end - quest.begin:.1f} s",
            at=quest.begin,
            recording=recording,
            help="A timer of 0.1 s has to publish at each tick while there is a goal.",
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


def garbage(value: float) -> str:
    """Return an explanation if a number can only be a wrongly typed field; else an empty text."""
    if math.isnan(value) or 0.0 < abs(value) < 1e-300 or 1e6 < abs(value) < math.inf:
        return (
            "This number is garbage: the field may hold an int or a np.float32 where ROS wants a "
            "Python float (write float(…) around it), or NaN came into the computation."
        )
    return ""
