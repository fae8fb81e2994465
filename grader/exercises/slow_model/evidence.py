"""Which scan is behind which command, and the verdicts that several checks share."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import NoReturn

import numpy as np

from grader.checks.commands import ZERO
from grader.checks.inferences import Answered
from grader.checks.predictions import predictions, rounded
from grader.checks.verdict import fail
from grader.checks.wiring import require_alive
from grader.exercises.slow_model.contract import (
    LATEST_STOP,
    LEAST_COMMANDS,
    LONGEST_GAP,
    MOST_COMMANDS,
)
from grader.recording import Floats, Recording

START_UP = 0.125  # [s] by which the first tick of a 50 ms timer has come
NEWEST = "Publish the newest prediction as it is, or 0.0. Are the features in the right order?"
RATE_FIRST = "Get inference_rate right first."
LEAST_MOVING = 3  # commands of a node that drives; one alone is no driving
STANDING, STRAY = -1, -2  # instead of a scan's number: a zero command; no scan's prediction


def behind(recording: Recording) -> np.ndarray:
    """Return the number of the newest scan that each command can be a prediction of, (n,) int.

    STANDING where the command is zero, STRAY where it is no scan's prediction. A command can rest
    only on what the model had said by then, which the judge knows, and that only on a scan that had
    come when the model was asked.
    """
    twists, said = recording.twists(), predictions(recording)
    inferences = Answered(recording)
    tolerance = inferences.tolerance(twists.linear_x)
    arrived = np.array([prediction.scan.t for prediction in said])
    least = np.array([prediction.least for prediction in said])
    most = np.array([prediction.most for prediction in said])
    found = np.full(len(twists.t), STRAY)
    for i, (t, speed) in enumerate(zip(twists.t, twists.linear_x, strict=True)):
        known = arrived <= inferences.newest_question(t, speed, tolerance)
        right = known & (least - tolerance <= speed) & (speed <= most + tolerance)
        if abs(speed) < ZERO:
            found[i] = STANDING
        elif right.any():
            found[i] = int(np.flatnonzero(right)[-1])
    return found


def require_commands(recording: Recording) -> None:
    """Fail unless the node ran to the end and published commands."""
    require_alive(recording)
    if not len(recording.twists().t):
        fail(
            "not a single Twist came on /cmd_vel",
            expected="one every 50 ms, 0.0 until there is a prediction",
            actual="silence",
            at=min(START_UP, recording.duration_s),
            recording=recording,
            help="Does the timer's callback run, and does it always reach its publish()?",
        )


def require_no_strays(
    recording: Recording,
    scans: np.ndarray,
    most: float = 0.02,
    help: str = NEWEST,
) -> None:
    """Fail if more of the commands than this are no scan's prediction, once there can be one."""
    twists, first = recording.twists(), recording.times("/scan")[:1]
    strays = np.flatnonzero((scans == STRAY) & (twists.t > first + LATEST_STOP))
    if len(strays) <= most * len(scans):
        return
    i = int(strays[0])
    arrived = [p for p in predictions(recording) if p.scan.t <= twists.t[i]]
    newest = arrived[-1].text if arrived else "nothing yet"
    fail(
        "a command matches no scan's prediction",
        expected=f"a clipped prediction; for the newest scan it is {newest}",
        actual=spell(float(twists.linear_x[i])),
        at=float(twists.t[i]),
        recording=recording,
        help=garbage(float(twists.linear_x[i]))
        or Answered(recording).unasked(float(twists.t[i]))
        or help,
    )


def ages(recording: Recording, scans: np.ndarray) -> Floats:
    """Return how old the scan behind each command is [s], (n,); inf where there is none."""
    arrived = np.array([scan.t for scan in recording.scans()])
    result = np.full(len(scans), math.inf)
    known = scans >= 0
    result[known] = recording.twists().t[known] - arrived[scans[known]]
    return result


def require_period(recording: Recording) -> None:
    """Fail unless commands came every 50 ms, within the contract's tolerance."""
    require_commands(recording)
    t = recording.twists().t
    ends = np.append(t, recording.duration_s)
    gaps = np.diff(ends)
    waits = np.array([recording.waited(*pair) for pair in pairwise(ends.tolist())])
    wrong = np.flatnonzero(gaps > LONGEST_GAP + waits + 1e-6)
    if len(wrong) and not _a_rare_delay(recording, gaps, len(wrong)):
        i = int(wrong[0])
        fail(
            "the control loop stumbles",
            expected=f"a command every 50 ms, no gap over {1000 * LONGEST_GAP:.0f} ms",
            actual=f"{1000 * gaps[i]:.0f} ms ({len(wrong)} of {len(gaps)} gaps are too long, "
            f"the longest {1000 * gaps.max():.0f} ms)",
            at=float(t[i]),
            recording=recording,
            help="Who keeps the timer waiting? A callback that runs the model blocks its executor "
            "and its callback group.",
        )
    rate = len(t) / (recording.duration_s - float(t[0]) + 0.05)
    if rate > MOST_COMMANDS:
        early = np.flatnonzero(np.diff(t, prepend=-np.inf) < 1.0 / MOST_COMMANDS)
        fail(
            "there are more commands than ticks",
            expected="20 per second, one for each tick of the timer",
            actual=f"{rate:.1f} per second",
            at=float(t[early[0]]) if len(early) else None,
            recording=recording,
            help="Only the control loop publishes; inference keeps its prediction for it.",
        )
    if rate < LEAST_COMMANDS and recording.live is None:
        fail(
            "the control loop is too slow",
            expected="20 commands per second, one every 50 ms",
            actual=f"{rate:.1f} per second",
            at=float(t[0]),
            recording=recording,
            help="Is the timer's period 0.05 s?",
        )


def _a_rare_delay(recording: Recording, gaps: np.ndarray, wrong: int) -> bool:
    """Tell whether, in real time, the gaps may be the scheduler's: few are wrong, and by little."""
    few = wrong <= max(1, len(gaps) // 100)
    return recording.live is not None and few and gaps.max() <= 2 * LONGEST_GAP


def require_rate(recording: Recording, least: float) -> None:
    """Fail unless new predictions reached /cmd_vel at this rate [Hz]."""
    require_commands(recording)
    scans, twists = behind(recording), recording.twists()
    require_no_strays(recording, scans)
    known = np.flatnonzero(scans >= 0)
    if not len(known):
        fail(
            "no prediction ever reached /cmd_vel: the robot was only told to stand",
            expected="commands that follow the model",
            actual=f"{len(twists.t)} commands, all of them 0.0",
            at=float(twists.t[-1]),
            recording=recording,
            help="Does inference run at all? If it does, are its scans too old already?",
        )
    begin = float(twists.t[known[0]])
    seconds = max(recording.duration_s - begin, LATEST_STOP)
    rate = len(np.unique(scans[known])) / seconds
    if rate < least:
        answered = [i.answered for i in recording.inferences if i.method == "predict"]
        each_second = len([t for t in answered if t <= recording.duration_s * 1e9]) / seconds
        if each_second >= least:
            fail(
                "inference keeps going, but its results are too old when they arrive",
                expected=f"at least {least} new predictions per second that count",
                actual=f"{rate:.1f} of the model's {each_second:.1f} answers per second",
                at=begin,
                recording=recording,
                help="Where does the scan wait before the model sees it, and the result before it "
                "is published? A model that runs in the scan's callback makes both wait.",
            )
        fail_pauses(recording, rate, least, begin)


def fail_pauses(recording: Recording, rate: float, least: float, begin: float) -> NoReturn:
    """Fail because of too few new predictions [Hz] since a time [s]."""
    fail(
        "inference does not keep going",
        expected=f"at least {least} new predictions per second",
        actual=f"{rate:.1f} per second, over {recording.duration_s - begin:.0f} s",
        at=begin,
        recording=recording,
        help="When one inference has ended, the next may start with the newest scan.",
    )


def require_ages(recording: Recording, limit: float) -> None:
    """Fail unless the scans behind 95 % of the commands are at most `limit` [s] old."""
    require_commands(recording)
    scans, twists = behind(recording), recording.twists()
    require_no_strays(recording, scans)
    known = np.flatnonzero(scans >= 0)
    if not len(known):
        fail("no prediction ever reached /cmd_vel", at=float(twists.t[-1]), recording=recording)
    old = ages(recording, scans)[known[0] :]
    p95 = float(np.sort(old)[math.ceil(0.95 * len(old)) - 1])
    if p95 <= limit:
        return
    i = int(known[0] + np.flatnonzero(old > limit)[0])
    standing = int((~np.isfinite(old)).sum())
    told = f"; {standing} of {len(old)} are 0.0, as if there were no prediction" * (standing > 0)
    fail(
        "the scans behind the commands are too old",
        expected=f"at most {limit} s (p95)",
        actual=(f"{p95:.2f} s (p95)" if p95 < math.inf else "too many zeros") + told,
        at=float(twists.t[i]),
        recording=recording,
        help="Do scans wait in a queue? Does inference idle with a scan at hand? Take the newest."
        if p95 < math.inf
        else "A prediction counts at every tick until its scan is 0.6 s old, not only once. "
        "If it is kept: do scans wait in a queue, so that it is too old when it comes?",
    )


def require_held(recording: Recording, tag: str, help: str) -> None:
    """Fail unless each bench scan with this tag brought its prediction.

    The bench repeats each scan for a while; the commands of its first 0.65 s are not judged.
    """
    require_commands(recording)
    judged = 0
    twists = recording.twists()
    for label, tags, begin, end, number in holds(recording):
        if tag not in tags:
            continue
        judged += 1
        during = np.flatnonzero((twists.t >= begin + LATEST_STOP) & (twists.t < end))
        right = predictions(recording)[number]
        if not len(during):
            fail(
                f"the node publishes nothing at “{label}”",
                expected="a command every 50 ms, whatever the model does",
                actual=f"none in {end - begin - LATEST_STOP:.2f} s",
                at=begin + LATEST_STOP,
                recording=recording,
                help="The control loop has to publish at each tick.",
            )
        for i in during.tolist():
            speed = float(twists.linear_x[i])
            if right.allows(speed):
                continue
            fail(
                f"“{label}”: wrong speed",
                expected=f"linear.x = {right.text}",
                actual=f"linear.x = {spell(speed)}",
                at=float(twists.t[i]),
                recording=recording,
                help=garbage(speed) or rounded(speed, right) or help,
            )
    if not judged:
        fail("the scenario ended before its scans were sent", recording=recording)


def require_holds(recording: Recording) -> None:
    """Fail if a robot is told to drive at max_speed 0.0, when predictions can have come."""
    require_commands(recording)
    twists = recording.twists()
    since = recording.scans()[0].t + LATEST_STOP
    moving = np.flatnonzero((np.abs(twists.linear_x) > ZERO) & (twists.t > since))
    if len(moving):
        speed = float(twists.linear_x[moving[0]])
        fail(
            "the robot is told to drive, though max_speed is 0.0 m/s",
            expected="linear.x = 0.0 m/s",
            actual=f"linear.x = {spell(speed)}",
            at=float(twists.t[moving[0]]),
            recording=recording,
            help=garbage(speed) or "max(0.0, min(max_speed, prediction)); in Python 0.0 is false.",
        )


def require_moves(recording: Recording, help: str = RATE_FIRST) -> None:
    """Fail if the node hardly ever commands what its model said: then its zeros show nothing."""
    require_commands(recording)
    twists = recording.twists()
    moving = np.flatnonzero(np.abs(twists.linear_x) > ZERO)
    if len(moving) < LEAST_MOVING:
        due = [said.scan.t + LATEST_STOP for said in predictions(recording) if said.least > ZERO]
        fail(
            f"the node {'nearly ' * bool(len(moving))}always publishes 0.0, so this proves nothing",
            expected="commands that follow the model where it works",
            actual=f"0.0 at {len(twists.t) - len(moving)} of {len(twists.t)} ticks"
            if len(moving)
            else "0.0 at every tick",
            at=min(due[0], recording.duration_s) if due else None,
            recording=recording,
            help=help,
        )
    answered = Answered(recording)
    tolerance = answered.tolerance(twists.linear_x)  # who rounds loses features
    unsaid = [
        i
        for i in moving.tolist()
        if answered.newest_question(float(twists.t[i]), float(twists.linear_x[i]), tolerance) < 0
    ]
    if len(unsaid) > len(moving) / 2:
        i = unsaid[0]
        fail(
            "a command came before the model had predicted that speed",
            expected="the newest prediction that predict() has returned, or 0.0",
            actual=spell(float(twists.linear_x[i])),
            at=float(twists.t[i]),
            recording=recording,
            help=answered.unasked(float(twists.t[i])) or "Publish the newest prediction as it is.",
        )


def holds(recording: Recording) -> list[tuple[str, tuple[str, ...], float, float, int]]:
    """Return label, tags, begin and end [s] and the first scan's number of each held scan."""
    scans, bench = recording.scans(), recording.scenario.bench_scans
    found: list[tuple[str, tuple[str, ...], float, float, int]] = []
    for number, scan in enumerate(scans):
        spec = bench[number]
        following = scans[number + 1].t if number + 1 < len(scans) else recording.duration_s
        if found and found[-1][0] == spec.label:
            label, tags, begin, _, first = found[-1]
            found[-1] = (label, tags, begin, following, first)
        else:
            found.append((spec.label, spec.tags, scan.t, following, number))
    return found


def spell(value: float) -> str:
    """Return a command's number as a student should see it."""
    return f"{value:.3g} m/s" if 0.0 < abs(value) < 0.0005 else f"{value:.4f} m/s"


def garbage(value: float) -> str:
    """Return an explanation if a number can only be a wrongly typed field; else an empty text."""
    if math.isnan(value):
        return "NaN: test the prediction with math.isfinite before you keep it."
    if 0.0 < abs(value) < 1e-300 or 1e6 < abs(value) < math.inf:
        return (
            "This number is garbage: the field holds an int or a np.float32 where ROS wants a "
            "Python float. Write float(…) around what you assign."
        )
    return ""
