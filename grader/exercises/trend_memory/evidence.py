"""What the node published after each scan, and the verdicts that several checks share."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from grader.checks.commands import Answer, answers, garbage, spell
from grader.checks.driving import path_length
from grader.checks.moments import came_to_rest
from grader.checks.reading import published
from grader.checks.verdict import fail
from grader.checks.wiring import require_alive
from grader.exercises.trend_memory.contract import (
    CLOSING_TOLERANCE,
    MEMORY_SIZE,
    RIGHT,
    Step,
    closing_speed,
    steps,
)
from grader.exercises.trend_memory.habits import APPROACH, PLAIN, SMALL, Habits, habits_of
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
    theirs: Step  # what the scan asks of a node with these habits
    tolerance: float = CLOSING_TOLERANCE

    @property
    def what(self) -> str:
        """The scan in words, for a student."""
        return f"scan {self.number} ({self.answer.what})"


def cases(recording: Recording, habits: Habits | None = None) -> list[Case]:
    """Return each scan that was sent, in order, with what followed it."""
    found = answers(recording)
    times, values = closing_speeds(recording)
    ends = np.append(np.searchsorted(times, [answer.scan.t for answer in found]), len(times))
    wanted = steps(tuple(answer.scan for answer in found))
    theirs, law = wanted, RIGHT
    if habits is not None and habits != Habits():
        law = habits.law or RIGHT
        theirs = steps(tuple(answer.scan for answer in found), law, early=habits.early)
    return [
        Case(
            wanted[i],
            answer,
            i + 1,
            tuple(values[int(ends[i]) : int(ends[i + 1])]),
            theirs[i],
            law.tolerance,
        )
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


def asked(recordings: Iterable[Recording]) -> tuple[Recording, ...]:
    """Return the recordings of what a check asks, without those that show the node's habits."""
    return tuple(recording for recording in recordings if recording.name not in PLAIN)


def shown_habits(recordings: Iterable[Recording]) -> Habits:
    """Return what the node makes of plain readings, by those of the recordings that show it."""
    plain = [recording for recording in recordings if recording.name in PLAIN]
    return habits_of(
        {
            recording.name: tuple((case.step, case.said) for case in cases(recording))
            for recording in plain
        }
    )


def told_by(
    recordings: tuple[Recording, ...], judged: tuple[Recording, ...]
) -> tuple[Habits, tuple[Recording, ...]]:
    """Return the node's habits, and where to judge them.

    Its numbers may follow a rule only where stamps are small; then `closing_speed` has failed.
    """
    habits = shown_habits(recordings)
    if habits.law is not None:
        return habits, judged
    (small,) = (recording for recording in recordings if recording.name == SMALL)
    there = habits_of({APPROACH: tuple((case.step, case.said) for case in cases(small))})
    return (habits, judged) if there.law is None else (there, (small,))


def require_memory(recording: Recording, habits: Habits, help: str) -> None:
    """Fail unless the closing speeds are those of the right readings, the node's habits given.

    A node whose numbers follow no rule shows by when it speaks whether its memory is full, unless
    it always speaks.
    """
    require_scans(recording)
    if habits.early:
        require_rule(recording, habits)
    stretches: list[list[Case]] = [[]]  # of readings that belong together
    for found in cases(recording, habits):
        case = replace(found, step=found.theirs)
        if case.step.emptied:
            stretches.append([])
        if case.step.spoken:
            stretches[-1].append(case)
        if not _is_early(case, habits):
            require_silence(recording, case, help)
        if habits.regular:
            require_one(recording, case, help)
        if habits.law:
            require_value(recording, case, help)
    for due in stretches:
        if due and not any(case.said for case in due):
            require_one(recording, due[0], help)


def require_plain(recording: Recording, habits: Habits, help: str, after: int = 0) -> None:
    """Fail unless the closing speeds follow the node's law, and one came late enough to tell."""
    require_scans(recording)
    require_rule(recording, habits)
    due = [case for case in cases(recording, habits) if case.step.spoken]
    for case in due:
        require_value(recording, case, help)
    telling = [case for case in due if case.number > after]
    if not any(case.said for case in telling):
        require_one(recording, telling[0], help)


def require_rule(recording: Recording, habits: Habits) -> None:
    """Fail if the closing speeds follow no rule: they don't tell what is asked then."""
    if habits.law is not None:
        return
    due = next((case for case in cases(recording) if case.step.spoken), None)
    fail(
        "what the closing speeds are made of can't be seen",
        expected="numbers that depend on the readings, at least by a rule with one mistake",
        actual="the numbers that closing_speed and forgets_old tell about",
        at=due.step.scan.t if due else None,
        recording=recording,
        help="Get closing_speed right first.",
    )


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
    """Fail if a closing speed is not minus the least-squares slope, or what the node makes it."""
    if not case.step.spoken:
        return
    least, most = case.theirs.bounds
    for value in case.said:
        if least - case.tolerance <= value <= most + case.tolerance:
            continue
        fail(
            f"wrong closing speed after {case.what}",
            expected=f"{(least + most) / 2:.3f} m/s, {_made_of(case)}",
            actual=f"{value:.3f} m/s" if abs(value) < 1e6 else f"{value:.3g} m/s",
            at=case.step.scan.t,
            recording=recording,
            help=garbage(value) or _sign(value, least, most) or _rounded(value, least) or help,
        )


def _made_of(case: Case) -> str:
    right = closing_speed(case.step.readings)
    if abs(right - sum(case.theirs.bounds) / 2) <= CLOSING_TOLERANCE:
        return "minus the slope over the last ten readings"
    return f"if made as in other scenarios (by the contract {right:.3f} m/s)"


def _is_early(case: Case, habits: Habits) -> bool:
    """Tell whether a node that never waits for ten readings does what it always does."""
    if not habits.early or not case.step.remembered:
        return False
    readings, law = case.step.readings, habits.law or RIGHT
    guess = closing_speed(readings, law) if len(readings) > 1 else 0.0
    return all(value == 0.0 or abs(value - guess) <= law.tolerance for value in case.said)


def _sign(value: float, least: float, most: float) -> str:
    """Say so if only the sign is wrong."""
    if abs(value) <= CLOSING_TOLERANCE or not least <= -value + CLOSING_TOLERANCE:
        return ""
    if -value - CLOSING_TOLERANCE > most:
        return ""
    return "Only the sign is wrong: it is *minus* the slope, positive for what comes closer."


def _rounded(value: float, right: float) -> str:
    """Say so if only the digits are missing."""
    if not any(value == round(right, digits) for digits in (0, 1, 2)):
        return ""
    return "The number is right, and rounded: publish it as it is, and round in the log only."


def require_speeds(
    recordings: Iterable[Recording], tag: str, help: str, habits: Habits | None = None
) -> None:
    """Fail unless the node commanded the right speed after every scan with this tag.

    If its habits are given, what they make of the readings is as good as the contract's closing
    speed, as long as the command depends on it.
    """
    said: list[tuple[float | None, frozenset[float]]] = []  # and what would have been right
    missed: tuple[Recording, float] | None = None  # the first scan that asked for something else
    judged = 0
    for recording in recordings:
        require_scans(recording)
        for case in cases(recording, habits):
            if missed is None and not _allows(case.step.speeds, case.answer.speed):
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


def require_forgotten(recording: Recording, habits: Habits) -> None:
    """Fail if the node decides by a trend that it should have forgotten.

    The scans judged are those that came when the memory had been emptied and was not full again.
    """
    emptied = False
    for case in cases(recording, habits):
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


def require_way(recording: Recording, habits: Habits) -> None:
    """Fail if the robot hardly moved: that it kept its distance shows nothing then.

    Unless it stood as its wrong closing speeds asked for, for which `closing_speed` has failed.
    """
    driven = path_length(recording)
    misled = habits.law is not None and habits.law != RIGHT
    if misled and all(map(_is_right, cases(recording, habits))):
        return
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
    return _allows(case.step.speeds | case.theirs.speeds, case.answer.speed)


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
