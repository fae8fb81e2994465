"""What the node published after each scan, and the verdicts that several checks share."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from grader.checks.commands import Answer, answers, garbage, spell
from grader.checks.driving import path_length
from grader.checks.moments import came_to_rest
from grader.checks.reading import published
from grader.checks.trend_memory.contract import (
    CLOSING_TOLERANCE,
    MEMORY_SIZE,
    Step,
    steps,
)
from grader.checks.verdict import fail
from grader.checks.wiring import require_alive
from grader.recording import Recording
from sim.messages import FLOAT64

TOPIC = "/closing_speed"
SPEED_TOLERANCE = 1e-3  # [m/s]
REACTIONS = 0.15  # other speeds than the usual one, for each scan for which that is wrong
CLEARANCE = 0.2  # [m] between the robot's edge and anything else
LEAST_WAY = 0.5  # [m] driven in each drive


@dataclass(frozen=True)
class Case:
    """A scan, what it asks for, and what the node published until the next one."""

    step: Step
    answer: Answer
    number: int  # of the scan, from 1
    said: tuple[float, ...]  # closing speeds [m/s]

    @property
    def what(self) -> str:
        """The scan in words, for a student."""
        return f"scan {self.number} ({self.answer.what})"


def cases(recording: Recording) -> list[Case]:
    """Return each scan that was sent, in order, with what followed it."""
    found = answers(recording)
    times, values = closing_speeds(recording)
    ends = np.append(np.searchsorted(times, [answer.scan.t for answer in found]), len(times))
    wanted = steps(tuple(answer.scan for answer in found))
    return [
        Case(wanted[i], answer, i + 1, tuple(values[int(ends[i]) : int(ends[i + 1])]))
        for i, answer in enumerate(found)
    ]


def closing_speeds(recording: Recording) -> tuple[list[float], list[float]]:
    """Return when closing speeds came [s], and their values [m/s]."""
    said = published(recording, TOPIC, FLOAT64)
    return [time for time, _ in said], [float(value.data) for _, value in said]


def require_scans(recording: Recording) -> None:
    """Fail unless the node ran to the end and every scan of the bench was sent."""
    require_alive(recording)
    if len(recording.scans()) < max(1, len(recording.scenario.bench_scans)):
        fail("the scenario ended before all of its scans were sent", recording=recording)


def require_closing_speeds(recording: Recording, help: str = "") -> None:
    """Fail unless the right closing speed, or nothing, followed every scan."""
    require_scans(recording)
    for case in cases(recording):
        require_silence(recording, case, help)
        require_one(recording, case, help)
        require_value(recording, case, help)


def require_silence(recording: Recording, case: Case, help: str = "") -> None:
    """Fail if a closing speed came where none may be published."""
    if not case.step.silent or not case.said:
        return
    step = case.step
    known = f"{step.known} reading{'s' * (step.known != 1)}"
    why = f"the memory holds {known}" if step.remembered else "it has no reading to remember"
    if step.remembered and step.known < MEMORY_SIZE and _emptied_before(recording, case):
        why += " since the stamps jumped"
    fail(
        f"a closing speed came after {case.what}, though {why}",
        expected=f"nothing on {TOPIC}",
        actual=f"{spell(case.said[0])} m/s",
        at=step.scan.t,
        recording=recording,
        help=help or "Return early: nothing is known yet, not even zero.",
    )


def require_one(recording: Recording, case: Case, help: str = "") -> None:
    """Fail unless one closing speed came where one has to be published."""
    if not case.step.spoken or len(case.said) == 1:
        return
    fail(
        f"{len(case.said) or 'no'} closing speeds came after {case.what}",
        expected=f"exactly one: the memory holds {MEMORY_SIZE} readings",
        actual=", ".join(f"{spell(value)} m/s" for value in case.said) or f"nothing on {TOPIC}",
        at=case.step.scan.t,
        recording=recording,
        help=help or "Publish once for each scan that is remembered, from the tenth one on.",
    )


def require_value(recording: Recording, case: Case, help: str = "") -> None:
    """Fail if a closing speed is not minus the least-squares slope."""
    if not case.step.spoken:
        return
    least, most = case.step.bounds
    for value in case.said:
        if least - CLOSING_TOLERANCE <= value <= most + CLOSING_TOLERANCE:
            continue
        fail(
            f"wrong closing speed after {case.what}",
            expected=f"{(least + most) / 2:.3f} m/s, minus the slope over the last ten readings",
            actual=f"{value:.3f} m/s" if abs(value) < 1e6 else f"{value:.3g} m/s",
            at=case.step.scan.t,
            recording=recording,
            help=garbage(value) or _sign(value, least, most) or help,
        )


def _sign(value: float, least: float, most: float) -> str:
    """Say so if only the sign is wrong."""
    if abs(value) <= CLOSING_TOLERANCE or not least <= -value + CLOSING_TOLERANCE:
        return ""
    if -value - CLOSING_TOLERANCE > most:
        return ""
    return "Only the sign is wrong: it is *minus* the slope, positive for what comes closer."


def require_speeds(recordings: Iterable[Recording], tag: str, help: str) -> None:
    """Fail unless the node commanded the right speed after every scan with this tag."""
    said: list[tuple[float | None, frozenset[float]]] = []  # and what would have been right
    missed: tuple[Recording, float] | None = None  # the first scan that asked for something else
    judged = 0
    for recording in recordings:
        require_scans(recording)
        for case in cases(recording):
            if missed is None and not _is_right(case):
                missed = recording, case.step.scan.t
            speed = None if case.answer.speed is None else round(case.answer.speed, 3)
            said.append((speed, frozenset(case.step.speeds)))
            if tag in case.answer.tags:
                judged += 1
                require_speed(recording, case, help)
    if not judged:
        fail(f"no scan with the tag {tag} was sent")
    usual, count = Counter(speed for speed, _ in said).most_common(1)[0]
    wrong = sum(not _allows(speeds, usual) for _, speeds in said)
    others = [(speeds, speed) for speed, speeds in said if speed != usual]
    one_is_right = any(_allows(speeds, speed) for speeds, speed in others)
    least = 1 if one_is_right else 2  # one blip is no reaction
    if len(others) < max(min(wrong, least), REACTIONS * wrong):
        exactly = "always" if count == len(said) else f"in {count} of {len(said)} answers"
        fail(
            "the command is the same whatever the node sees",
            expected="a speed that depends on what is ahead",
            actual="nothing on /cmd_vel" if usual is None else f"{exactly} {usual:.2f} m/s",
            at=missed[1] if missed else None,
            recording=missed[0] if missed else recording,
            help="Get drives_free and stops_near right first.",
        )


def require_forgotten(recording: Recording) -> None:
    """Fail if the node decides by a trend that it should have forgotten.

    The scans judged are those that came when the memory had been emptied and was not full again.
    """
    emptied = False
    for case in cases(recording):
        emptied = emptied or case.step.emptied
        if emptied and case.answer.count and case.step.known < MEMORY_SIZE:
            help = "With the memory goes the closing speed: it is not known until there are ten."
            require_speed(recording, case, help)


def require_speed(recording: Recording, case: Case, help: str = "") -> None:
    """Fail unless the command in force after a scan has the right linear.x."""
    right, speed = case.step.speeds, case.answer.speed
    if _is_right(case):
        return
    fail(
        f"wrong speed after {case.what}",
        expected="linear.x = " + " or ".join(f"{value:.1f} m/s" for value in sorted(right)),
        actual="nothing on /cmd_vel" if speed is None else f"linear.x = {spell(speed)} m/s",
        at=case.step.scan.t,
        recording=recording,
        help=garbage(speed or 0.0) or _time_left(case) or help,
    )


def require_distance(recording: Recording) -> None:
    """Fail if the robot touched something or came too near to it."""
    require_alive(recording)
    truth = recording.truth
    nearest = int(np.argmin(truth.clearance))
    if truth.contact.any() or truth.clearance[nearest] < CLEARANCE:
        fail(
            "the robot came too near to something",
            expected=f"clearance of at least {CLEARANCE} m",
            actual="contact" if truth.contact.any() else f"{truth.clearance[nearest]:.3f} m",
            at=truth.t[nearest] / 1e9,
            recording=recording,
            help="Watch the replay from two seconds before: what was the closing speed?",
        )


def require_way(recording: Recording) -> None:
    """Fail if the robot hardly moved: that it kept its distance shows nothing then."""
    driven = path_length(recording)
    if driven < LEAST_WAY:
        fail(
            "the robot hardly moved, so this proves nothing",
            expected="a robot that drives at 0.3 m/s where there is room and time",
            actual=f"{driven:.2f} m driven",
            at=came_to_rest(recording),
            recording=recording,
            help="Get drives_free right first.",
        )


def _is_right(case: Case) -> bool:
    """Tell whether the command in force after a scan has a right linear.x."""
    return _allows(case.step.speeds, case.answer.speed)


def _allows(speeds: Iterable[float], said: float | None) -> bool:
    """Tell whether a speed [m/s] is one of the right ones."""
    return said is not None and any(abs(said - value) <= SPEED_TOLERANCE for value in speeds)


def _time_left(case: Case) -> str:
    """Return how much time was left before a collision, if that asks for the stop; else empty."""
    if not case.step.spoken or case.step.distance is None:
        return ""
    closing = case.step.bounds[1]
    if closing <= 0.0 or case.step.speeds != {0.0} or case.step.distance < 0.5:
        return ""
    left = case.step.distance / closing
    return f"{case.step.distance:.2f} m at a closing speed of {closing:.2f} m/s are {left:.1f} s."


def _emptied_before(recording: Recording, case: Case) -> bool:
    return any(step.emptied for step in steps(recording.scans()[: case.number]))
