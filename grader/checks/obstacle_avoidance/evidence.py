"""Which command followed which scan, and the verdicts that several checks share."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from grader.checks.obstacle_avoidance.contract import front_distance, right_speeds
from grader.checks.turns import turns
from grader.checks.verdict import fail
from grader.checks.wiring import require_alive
from grader.recording import Recording, Scan

CAUTION = 0.05  # [m/s] slower before an obstacle than where the way is free, on average
ZERO = 1e-6  # [m/s, rad/s] "zero" in every field
SPEED_TOLERANCE = 1e-3  # [m/s]
CLEARANCE = 0.2  # [m] to keep from the robot's edge
FIELDS = ("linear.x", "linear.y", "linear.z", "angular.x", "angular.y", "angular.z")


@dataclass(frozen=True)
class Answer:
    """A scan and the command in force when the next scan came."""

    scan: Scan
    label: str  # of a bench scan; empty in a closed loop
    tags: tuple[str, ...]
    count: int  # commands between this scan and the next
    speed: float | None  # linear.x in force [m/s]; None: there has been no command yet

    @property
    def what(self) -> str:
        """The scan in words, for a student."""
        if self.label:
            return f"“{self.label}”"
        distance = front_distance(self.scan)
        return "a scan with nothing usable ahead" if distance is None else f"{distance:.2f} m ahead"


def answers(recording: Recording) -> list[Answer]:
    """Return every delivered scan with what the node made of it."""
    twists, bench = recording.twists(), recording.scenario.bench_scans
    scans, first = turns(recording)
    found = []
    for i, scan in enumerate(scans):
        begin, end = int(first[i]), int(first[i + 1])
        found.append(
            Answer(
                scan=scan,
                label=bench[i].label if bench else "",
                tags=bench[i].tags if bench else (),
                count=end - begin,
                speed=float(twists.linear_x[end - 1]) if end else None,
            )
        )
    return found


def judged(recording: Recording, tag: str = "") -> list[Answer]:
    """Return every bench scan that carries the tag; fail if not all came, or none was answered.

    Scans at the end whose answer would come after it are left out, in real time (see `turns`).
    """
    require_alive(recording)
    scenario = recording.scenario
    if not scenario.faults.scan_loss and len(recording.scans()) != len(scenario.bench_scans):
        fail("the scenario ended before all of its scans were sent", recording=recording)
    found = [answer for answer in answers(recording) if not tag or tag in answer.tags]
    if not found:
        pairs = zip(recording.scans(), scenario.bench_scans, strict=False)
        fail(
            f"no command has come by the scans “{tag}”",
            expected="a Twist for each scan",
            actual="none, until the end",
            at=next((scan.t for scan, bench in pairs if not tag or tag in bench.tags), None),
            recording=recording,
            help="Publish once at the end of the scan callback, whatever the scan was.",
        )
    return found


def require_speeds(recording: Recording, tag: str, help: str = "") -> None:
    """Fail unless the node lived and drove as the contract says at every scan with this tag."""
    for answer in judged(recording, tag):
        require_speed(recording, answer, help)
    require_reaction(recording)


def require_reaction(recording: Recording) -> None:
    """Fail if the node always says the same, though what it sees asks for different speeds.

    Without this a node that only ever says "stop" would win the points of every stop.
    """
    found = answers(recording)
    same_is_right = bool(frozenset.intersection(*(right_speeds(answer.scan) for answer in found)))
    said = {round(answer.speed, 3) for answer in found if answer.speed is not None}
    if same_is_right or len(said) > 1:
        return
    fail(
        "the node says the same whatever it sees",
        expected="a speed that depends on the distance ahead",
        actual=", ".join(f"always {speed:.2f} m/s" for speed in said) or "nothing on /cmd_vel",
        at=next((answer.scan.t for answer in found if not _is_right(answer)), None),
        recording=recording,
        help="Get clear_zone, slow_zone and stop_zone right first.",
    )


def require_speed(recording: Recording, answer: Answer, help: str = "") -> None:
    """Fail unless the command in force after this scan has the right linear.x."""
    right = right_speeds(answer.scan)
    expected = " or ".join(f"{speed:.2f} m/s" for speed in sorted(right))
    if answer.speed is None:
        fail(
            f"no command has come by {answer.what}",
            expected=f"a Twist with linear.x = {expected}",
            actual="nothing on /cmd_vel",
            at=answer.scan.t,
            recording=recording,
            help="Publish once at the end of the scan callback, whatever the scan was.",
        )
    if not _is_right(answer):
        fail(
            f"{answer.what}: wrong speed",
            expected=f"linear.x = {expected}",
            actual=f"linear.x = {spell(answer.speed)} m/s",
            at=answer.scan.t,
            recording=recording,
            help=garbage(answer.speed) or help,
        )


def require_one_command_each(recording: Recording) -> None:
    """Fail unless exactly one command followed each scan, and none came before the first."""
    require_alive(recording)
    found, twists = answers(recording), recording.twists()
    if not found:
        fail("no scan was sent", recording=recording)
    if len(twists.t) and twists.t[0] < found[0].scan.t:
        fail(
            "a command came before the first scan",
            expected="silence until there is something to decide on",
            actual=f"a Twist at {twists.t[0]:.3f} s, the first scan at {found[0].scan.t:.3f} s",
            at=float(twists.t[0]),
            recording=recording,
            help="Publish from the scan callback only, not from the constructor or a timer.",
        )
    for answer in found:
        if answer.count != 1:
            fail(
                f"{answer.count} commands followed {answer.what}",
                expected="exactly one Twist for each scan",
                actual=f"{answer.count} between this scan and the next",
                at=answer.scan.t,
                recording=recording,
                help="Look for a timer, a second publish(), or a return before the publish().",
            )


def require_distance(recording: Recording) -> None:
    """Fail if the robot touched something or came nearer than the contract allows."""
    require_alive(recording)
    require_reaction(recording)
    truth = recording.truth
    if truth.contact.any():
        at = truth.t[int(np.argmax(truth.contact))] / 1e9
        fail(
            "the robot ran into something",
            expected=f"clearance of at least {CLEARANCE} m",
            actual="contact",
            at=at,
            recording=recording,
            help="Watch the replay from a second before the contact: what did the lidar see?",
        )
    nearest = int(np.argmin(truth.clearance))
    if truth.clearance[nearest] < CLEARANCE:
        fail(
            "the robot came too near to something",
            expected=f"clearance of at least {CLEARANCE} m",
            actual=f"{truth.clearance[nearest]:.3f} m",
            at=truth.t[nearest] / 1e9,
            recording=recording,
            help="It has to stop while the nearest distance ahead is still 0.5 m.",
        )


def require_caution(recordings: Sequence[Recording]) -> None:
    """Fail if the node is no slower before an obstacle than where the way is free.

    Without this a node that creeps or stutters blindly would win the points for touching nothing.
    """
    by_run = [(recording, answer) for recording in recordings for answer in answers(recording)]
    found = [answer for _, answer in by_run]
    free, stop = (_mean_speed(found, frozenset({right})) for right in (0.5, 0.0))
    if free - stop >= CAUTION:  # not so if one of them is NaN: it was never asked for
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
    return answer.speed is not None and any(
        abs(answer.speed - speed) <= SPEED_TOLERANCE for speed in right_speeds(answer.scan)
    )


def _first_wrong(
    by_run: Sequence[tuple[Recording, Answer]], right: float
) -> tuple[Recording, float | None] | None:
    """Return where and when [s] a scan that asks for this speed first got another."""
    wrong = (
        (recording, answer.scan.t)
        for recording, answer in by_run
        if right_speeds(answer.scan) == {right} and not _is_right(answer)
    )
    return next(wrong, None)


def _spell_mean(speed: float) -> str:
    return "no scan" if math.isnan(speed) else f"{speed:.2f} m/s"


def _mean_speed(found: Sequence[Answer], right: frozenset[float]) -> float:
    """Return the mean finite speed where this is the right one [m/s]; NaN if there is none."""
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
                help="Decide anew at each scan; look only ahead, and publish every time.",
            )
    if not count:
        fail("the way was never free for long enough to judge", recording=recording)


def spell(value: float) -> str:
    """Return a command's number as a student should see it."""
    return f"{value:.3g}" if 0.0 < abs(value) < 0.005 else f"{value:.2f}"


def garbage(value: float) -> str:
    """Return an explanation if a number can only be a wrongly typed field; else an empty text."""
    if math.isnan(value) or 0.0 < abs(value) < 1e-300 or 1e6 < abs(value) < math.inf:
        return (
            "This number is garbage: the field holds an int or a np.float32 where ROS wants a "
            "Python float. Write float(…) around what you assign."
        )
    return ""
