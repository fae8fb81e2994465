"""Whether the commands fit the scans: the verdicts that several checks of exercise 1 share."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Collection, Mapping, Sequence

import numpy as np

from grader.checks.ahead import front_distance
from grader.checks.commands import Answer, answers, garbage, judged, spell
from grader.checks.driving import require_no_contact
from grader.checks.verdict import fail
from grader.checks.wiring import require_alive
from grader.exercises.obstacle_avoidance.contract import FULL_SPEED, SLOW_SPEED, right_speeds
from grader.recording import Recording

CAUTION = 0.05  # [m/s] slower before an obstacle than where the way is free, on average
Speeds = tuple[float, float]  # [m/s] the least and the greatest
CONTRACT = {speed: (speed, speed) for speed in (0.0, SLOW_SPEED, FULL_SPEED)}  # [m/s]
SPEED_TOLERANCE = 1e-3  # [m/s]
REACTIONS = 0.15  # other speeds than the usual one, for each scan for which that is wrong
CLEARANCE = 0.2  # [m] between the robot's edge and anything else


def require_speeds(
    recording: Recording, tag: str, help: str = "", *, own: Mapping[float, Speeds] = CONTRACT
) -> None:
    """Fail unless the node ran to the end, with the right speed after each scan with this tag.

    `own` has the speeds [m/s] that count for each of the contract's (see `own_speeds`).
    """
    for answer in judged(recording, tag):
        require_speed(recording, answer, help, own)
    require_reaction(recording)


def own_speeds(zones: Recording) -> Mapping[float, Speeds]:
    """Return the speeds [m/s] that this node has for each of the contract's.

    A wrong speed of a zone is the business of that zone's check; the checks of perception ask which
    zone the node takes a scan for. They can if it is faster in each zone than in the nearer ones,
    and does not drive ahead in the nearest, or does so neither in the slow zone; otherwise, and if
    its speeds are right, the contract's count.
    """
    require_alive(zones)
    own: dict[float, Speeds] = {}
    for tag, right in (("stop", 0.0), ("slow", SLOW_SPEED), ("clear", FULL_SPEED)):
        said = [answer.speed for answer in answers(zones) if tag in answer.tags]
        known = [speed for speed in said if speed is not None and math.isfinite(speed)]
        if not known or len(known) < len(said):
            return CONTRACT
        least, most = min(known), max(known)
        near = max(abs(least - right), abs(most - right)) <= SPEED_TOLERANCE
        own[right] = (right, right) if near else (least, most)
    stop, slow, clear = own.values()
    apart = (slow == stop or slow[0] - stop[1] >= CAUTION) and clear[0] - slow[1] > SPEED_TOLERANCE
    one_each = slow[0] < slow[1] or clear[0] - slow[1] >= CAUTION
    return own if stop[1] == clear[1] - clear[0] == 0.0 and apart and one_each else CONTRACT


def require_reaction(recording: Recording) -> None:
    """Fail if the node nearly always commands one speed, though the scans call for different ones.

    Without this a node that only ever stops would pass every check that expects a stop. One that
    does so but for a few scans, whatever they show, does not react either.
    """
    found = answers(recording)
    said = [None if answer.speed is None else round(answer.speed, 3) for answer in found]
    usual, count = Counter(said).most_common(1)[0] if said else (None, 0)
    same_is_right = bool(frozenset.intersection(*(right_speeds(answer.scan) for answer in found)))
    wrong = sum(not _allows(answer, usual) for answer in found)
    least = REACTIONS * wrong if recording.scenario.bench_scans else 1  # a drive shows what it may
    if same_is_right or not wrong or len(said) - count >= least:
        return
    exactly = "always" if count == len(said) else f"in {count} of {len(said)} answers"
    fail(
        "the command is the same whatever the node sees",
        expected="a speed that depends on the distance ahead",
        actual="nothing on /cmd_vel" if usual is None else f"{exactly} {usual:.2f} m/s",
        at=next((answer.scan.t for answer in found if not _is_right(answer)), None),
        recording=recording,
        help="Log the distance. Is it the same for every scan? Then look at the perception. If "
        "not: does the decision use it, and do you publish the result?",
    )


def require_speed(
    recording: Recording, answer: Answer, help: str = "", own: Mapping[float, Speeds] = CONTRACT
) -> None:
    """Fail unless the command in force after this scan has the right linear.x."""
    contract = right_speeds(answer.scan)
    right = [own[speed] for speed in sorted(contract)]
    expected = " or ".join(f"{speed:.2f} m/s" for speed in sorted(contract))
    if any(own[speed] != (speed, speed) for speed in contract):
        taken = " or ".join(_spell_speeds(speeds) for speeds in right)
        expected += f" ({taken} would do here, as your node says so in this zone)"
    if answer.speed is None:
        fail(
            f"there was still no command after {answer.what}",
            expected=f"a Twist with linear.x = {expected}",
            actual="nothing on /cmd_vel",
            at=answer.scan.t,
            recording=recording,
            help="Publish once at the end of the scan callback, whatever the scan was.",
        )
    if any(_within(answer.speed, speeds) for speeds in right):
        return
    if not answer.count:
        fail(
            f"{answer.what}: no command came, and the last one still counts",
            expected=f"a Twist with linear.x = {expected}",
            actual=f"no Twist for this scan; the robot goes on at {_spell(answer.speed)} m/s",
            at=answer.scan.t,
            recording=recording,
            help="Publish once at the end of the scan callback, whatever the scan was.",
        )
    fail(
        f"{answer.what}: wrong speed",
        expected=f"linear.x = {expected}",
        actual=f"linear.x = {_spell(answer.speed)} m/s",
        at=answer.scan.t,
        recording=recording,
        help=garbage(answer.speed) or _odd(answer.speed, own) or help,
    )


def _odd(speed: float, own: Mapping[float, Speeds]) -> str:
    """Say so if no zone has such a speed, nor one of the node's: then no limit is to blame."""
    if any(_within(speed, speeds) for speeds in own.values()):
        return ""
    return (
        f"No zone has a speed of {_spell(speed)} m/s: they are 0.0, 0.15 and 0.5 m/s, forwards. "
        "Look at what is assigned to linear.x."
    )


def _within(said: float, speeds: Speeds) -> bool:
    """Tell whether a speed is one of these [m/s]."""
    return speeds[0] - said <= SPEED_TOLERANCE and said - speeds[1] <= SPEED_TOLERANCE


def _spell(speed: float) -> str:
    """Return a speed [m/s] with as many digits as tell it from the contract's."""
    text = spell(speed)
    alike = text in {spell(right) for right in CONTRACT}
    return f"{speed:.4g}" if alike and not _among(speed, CONTRACT) else text


def _spell_speeds(speeds: Speeds) -> str:
    least, most = speeds
    return _spell(least) if least == most else f"{_spell(least)} to {_spell(most)}"


def require_distance(recording: Recording) -> None:
    """Fail if the robot touched something or came nearer than the contract allows."""
    require_alive(recording)
    require_reaction(recording)
    require_no_contact(
        recording,
        "Watch the replay from a second before the contact: what did the lidar see?",
        expected=f"clearance of at least {CLEARANCE} m",
    )
    truth = recording.truth
    nearest = int(np.argmin(truth.clearance))
    if truth.clearance[nearest] < CLEARANCE:
        fail(
            "the robot came too near to something",
            expected=f"clearance of at least {CLEARANCE} m",
            actual=f"{truth.clearance[nearest]:.3f} m",
            at=truth.t[nearest] / 1e9,
            recording=recording,
            help="It must stop as soon as the nearest reading ahead is below 0.5 m.",
        )


def require_caution(recordings: Sequence[Recording]) -> None:
    """Fail if the node is no slower before an obstacle than where the way is free.

    Without this a node that creeps blindly, or in fits and starts, would win the points for
    touching nothing.
    """
    by_run = [(recording, answer) for recording in recordings for answer in answers(recording)]
    found = [answer for _, answer in by_run]
    free, slow, stop = (_mean_speed(found, frozenset({right})) for right in (0.5, 0.15, 0.0))
    nearest = slow if math.isnan(stop) else stop  # who stops early never sees a scan that asks so
    if free - nearest >= CAUTION:  # never true of NaN, where no scan asked for one of the speeds
        return
    where, at = _first_wrong(by_run, 0.0) or _first_wrong(by_run, 0.5) or (recordings[0], None)
    fail(
        "the robot touched nothing, but not because of what it saw",
        expected="fast where the way is free, standing within 0.5 m of an obstacle",
        actual=f"on average {_spell_mean(free)} where it is free, {_spell_mean(stop)} within 0.5 m",
        at=at,
        recording=where,
        help="Get clear_zone and stop_zone right first.",
    )


def _is_right(answer: Answer) -> bool:
    """Tell whether the command in force after this scan has the right linear.x."""
    return _allows(answer, answer.speed)


def _allows(answer: Answer, said: float | None) -> bool:
    """Tell whether a speed [m/s] is right for this scan."""
    return said is not None and _among(said, right_speeds(answer.scan))


def _among(said: float, speeds: Collection[float]) -> bool:
    """Tell whether a speed is one of these [m/s]."""
    return any(abs(said - speed) <= SPEED_TOLERANCE for speed in speeds)


def _first_wrong(
    by_run: Sequence[tuple[Recording, Answer]], right: float
) -> tuple[Recording, float | None] | None:
    """Return where and when [s] a scan that asks for only this speed first got another."""
    wrong = (
        (recording, answer.scan.t)
        for recording, answer in by_run
        if right_speeds(answer.scan) == {right} and not _is_right(answer)
    )
    return next(wrong, None)


def _spell_mean(speed: float) -> str:
    return "no scan" if math.isnan(speed) else f"{speed:.2f} m/s"


def _mean_speed(found: Sequence[Answer], right: frozenset[float]) -> float:
    """Return the mean of the finite speeds where only these are right [m/s]; NaN: no such scan."""
    asked = [answer.speed for answer in found if right_speeds(answer.scan) == right]
    finite = [speed for speed in asked if speed is not None and math.isfinite(speed)]
    return sum(finite) / len(finite) if finite else math.nan


def require_moving_when_free(recording: Recording, patience: float = 1.5) -> None:
    """Fail if the robot stands although the way has been free for `patience` [s]."""
    require_alive(recording)
    require_reaction(recording)
    truth = recording.truth
    free_since: float | None = None
    count = 0
    for scan in recording.scans():
        if 0.0 in right_speeds(scan):
            free_since = None
            continue
        free_since = scan.t if free_since is None else free_since
        if scan.t - free_since < patience:
            continue
        count += 1
        speed = float(np.interp(scan.t, truth.t / 1e9, truth.v))
        if speed < 0.05:
            distance = front_distance(scan)
            fail(
                f"the robot stands, though the way has been free for {scan.t - free_since:.1f} s",
                expected=f"driving on: the nearest thing ahead is {distance:.2f} m away",
                actual=f"{abs(speed):.2f} m/s",
                at=scan.t,
                recording=recording,
                help="Decide again at each scan; look only ahead, and publish every time.",
            )
    if not count:
        fail("the way was never free for long enough to judge", recording=recording)
