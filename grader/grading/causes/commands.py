"""Causes that the commands themselves show: none at all, garbage, a wrong sign, field or period.

Each is a fact about what was published. Only what a fact can't say is asked.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np

from grader.checks.ahead import front_distance
from grader.checks.commands import FIELDS, ZERO, spell
from grader.course.exercises import Exercise
from grader.exercises import contract_of
from grader.grading.causes.cause import ByName, Cause, Failed, Hint, hint_for
from grader.grading.causes.own_words import plain_words_on
from grader.recording import Floats, Recording
from sim.messages import CMD_VEL_TOPIC

ACTS = ("one_command_per_scan", "only_linear_x", "control_rate", "control_period", "limits")
DENORMAL = 1e-300  # [m/s] an int's or a np.float32's memory, read as a double
STEADY = 0.01  # of a period
FEW = 3  # commands, to see a period
MIN_PREDICTIONS = 6  # to see that they differ
APART = 0.1  # [m/s]
FAR = 1.5  # [m]
QUOTED = 160  # [characters] of the log, beside which there are words
SLOW = 0.05  # [m/s] and below says nothing
ROBOTS_OWN = (0, 5)  # linear.x and angular.z

NO_FEATURES = (
    "It has loaded its model and never asks it. If there seem to be no features: is "
    "extract_features filled in, and are the limits of its sectors in radians, as the beams' "
    "angles are?"
)
GARBAGE = (
    "which is garbage. Did an int, an array or an np.float32 get into a float field? Write "
    "float(…) around what you assign to linear.x and angular.z."
)


def cause_of_commands(exercise: Exercise, failed: Sequence[Failed], trials: ByName) -> Cause | None:
    """Return what is wrong with the commands, whatever the node perceives and decides."""
    topics = {topic.name for topic in exercise.topics if topic.direction == "publish"}
    ran = [each for each in trials.values() if each.outcome.completed and each.delivered]
    if CMD_VEL_TOPIC not in topics or not ran:
        return None
    for look in (_mute, _garbage, _other_field, _backwards, _slow_timer):
        if text := look(exercise, ran):
            hint = hint_for(exercise, failed[:1]) if failed[0].id in ACTS else None
            return _cause(text, failed, hint)
    return None


def never_moves(trials: ByName) -> bool:
    """Return whether no command of any trial moves the robot: many mistakes look like that."""
    values = [np.abs(each.twists().values) for each in trials.values()]
    return bool(values) and all(
        np.nan_to_num(each, nan=1).max(initial=0) <= ZERO for each in values
    )


def cause_of_standing(_: Exercise, failed: Sequence[Failed], trials: ByName) -> Cause | None:
    """Return why a node only ever commands zeros, or always the same, if there is evidence."""
    recording = trials.get(failed[0].scenario or "")
    if recording is None or not len(recording.twists().t):
        return None
    if text := _cut(trials):
        return _cause(text, failed)
    text = (never_moves(trials) and _why_it_stands(recording)) or _unmoved(recording)
    return _cause(text, failed) if text else None


def _cause(text: str, failed: Sequence[Failed], hint: Hint | None = None) -> Cause:
    """Return a cause of all failed checks, whose own hints lead elsewhere."""
    said = f"{text[0].upper()}{text[1:]}"
    explains = tuple(check.id for check in failed)
    return Cause(said, failed[0].kind, hint=hint, explains=explains, check=failed[0].id)


def _why_it_stands(recording: Recording) -> str:
    said = Counter(line.text for line in recording.log if line.level in ("warn", "error", "fatal"))
    asks = any(not each.is_load for each in recording.inferences)
    for line, often in said.most_common(1):
        quoted, words = " ".join(line.split()), plain_words_on(line)
        quoted = quoted if len(quoted) <= QUOTED else f"{quoted[:QUOTED]} …"
        times = "once" if often == 1 else f"{often} times"
        seen = f"every command is zero, and the node's log says {times}: “{quoted}”."
        if words:
            return f"{seen} Perhaps: {words}."
        if not recording.inferences and (free := _free(recording)):
            return f"{seen} {free}"
        return seen if asks or not recording.inferences else f"{seen} {NO_FEATURES}"
    if asks or not recording.inferences:
        return ""
    return (
        "every command is zero, and the node never asks its model, though it has loaded it. Is the "
        "model kept in an attribute (self.model = …), is a thread that should ask it started "
        "(start()), and does the callback get as far as predict?"
    )


def _free(recording: Recording) -> str:
    """Say that a node stands that sees a free way."""
    ahead = [front_distance(scan) for scan in recording.scans()]
    far = sum(distance is not None and distance > FAR for distance in ahead)
    if far < MIN_PREDICTIONS:
        return ""
    return (
        f"{far} of the {len(ahead)} scans have readings ahead, and none nearer than {FAR:g} m. "
        "Does an `except` hide an error of its own (let it through once, and see), or does a "
        "comparison leave good readings out?"
    )


def _unmoved(recording: Recording) -> str:
    """One speed for all predictions."""
    speeds = recording.twists().linear_x
    said = [each.said[0] for each in recording.inferences if not each.is_load and each.said]
    if len(said) < MIN_PREDICTIONS or np.ptp(speeds) > ZERO or not np.ptp(said) > APART:
        return ""
    return (
        f"every command is {spell(speeds[0])} m/s, and the model says {min(said):.2f} to "
        f"{max(said):.2f} m/s. Is its answer used, or thrown away as too old or invalid? "
        "Or do int(…), //, or a clip that is not min(max(speed, 0.0), self.max_speed), make it one "
        "number?"
    )


def _cut(trials: ByName) -> str:
    """Every prediction between 0 and 1 becomes 0."""
    pairs = []
    for run in trials.values():
        commands = run.twists()
        for each in run.inferences:
            at = int(np.searchsorted(commands.t, each.answered / 1e9 - STEADY))
            if not each.is_load and len(each.said) == 1 and at < len(commands.t):
                pairs.append((each.said[0], float(commands.linear_x[at])))
    telling = [said for said, speed in pairs if SLOW < said < 1.0 and abs(speed) <= ZERO]
    kept = [said for said, speed in pairs if SLOW < said < 1.0 and abs(speed) > ZERO]
    if len(telling) < MIN_PREDICTIONS or kept or np.ptp(telling) <= APART:
        return ""
    return (
        f"the model says {min(telling):.2f} to {max(telling):.2f} m/s, and each of these "
        f"{len(telling)} times the command is 0.00 m/s. Is its answer used, or thrown away as "
        "too old or invalid? Or do int(…), // or a clip with swapped limits make it 0?"
    )


def _mute(exercise: Exercise, ran: Sequence[Recording]) -> str:
    if any(recording.of(CMD_VEL_TOPIC) for recording in ran):
        return ""
    period = contract_of(exercise).period
    if period is not None:
        return (
            "not one command comes on /cmd_vel, though the node has a publisher. Does its timer "
            f"fire (its period is in seconds: {period:g}; has the executor that spins got the "
            "node?), does the callback return before its publish(), and is what it waits for kept "
            "in attributes (self.… = …)?"
        )
    return (
        "not one command comes on /cmd_vel, though the node has a publisher. Is there a publish() "
        "in the callback of /scan, and does nothing return before it?"
    )


def _garbage(_: Exercise, ran: Sequence[Recording]) -> str:
    for recording in ran:
        twists = recording.twists()
        values = np.abs(twists.values)
        for row, column in np.argwhere((values > 0) & (values < DENORMAL)):
            value, at = twists.values[row, column], twists.t[row]
            return f"at {at:.2f} s of {recording.name} {FIELDS[column]} is {value:.2g}, {GARBAGE}"
    return ""


def _other_field(_: Exercise, ran: Sequence[Recording]) -> str:
    """The value of a field stands in another field of the same vector."""
    used = np.abs(np.nan_to_num(_values(ran))).max(axis=0, initial=0) > ZERO
    for own in ROBOTS_OWN:
        vector = range(own - own % 3, own - own % 3 + 3)
        others = [i for i in vector if i != own and used[i]]
        if not used[own] and len(others) == 1:
            return (
                f"the node sets {FIELDS[others[0]]}, and {FIELDS[own]} stays 0. This robot only "
                "drives along x and turns about z: linear.x and angular.z."
            )
    return ""


def _backwards(exercise: Exercise, ran: Sequence[Recording]) -> str:
    speeds = _values(ran)[:, 0]
    reverses = contract_of(exercise).limits.slowest < 0.0
    if reverses or not (speeds < -ZERO).any() or (speeds > ZERO).any():
        return ""
    return "the node only ever drives backwards: its linear.x is negative. Forwards is positive."


def _slow_timer(exercise: Exercise, ran: Sequence[Recording]) -> str:
    """A timer of ten, a hundred, … times its period is a slip of units."""
    right = contract_of(exercise).period
    gaps = [np.diff(each.twists().t) for each in ran if len(each.twists().t) >= FEW]
    if right is None or not gaps:
        return ""
    step = float(np.median(np.concatenate(gaps)))
    power = np.log10(step / right) if step > 0 else 0.0
    steady = all(np.all(np.abs(each - step) <= STEADY * step) for each in gaps)
    if not steady or round(power) < 1 or abs(power - round(power)) > STEADY:
        return ""
    return (
        f"a command comes every {step:g} s instead of every {right:g} s. The timer's period is in "
        f"seconds: create_timer({right:g}, …)."
    )


def _values(ran: Sequence[Recording]) -> Floats:
    return np.concatenate([recording.twists().values for recording in ran])
