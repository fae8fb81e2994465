"""What to say of a program that passes all: what was good, and what a reader would remark.

Neither costs or brings a point, and all of it is seen in the recordings.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from grader.advice.slips import said_in
from grader.grading.causes.cause import sentences
from grader.recording import Recording, views
from rclpy_virtual_time import Note
from sim.clearance import FARTHEST
from sim.messages import CMD_VEL_TOPIC

DRIVE = 0.5  # [m] less than this is no drive
STANDS = 1e-6  # [m/s], [rad/s]
TURNS = 0.3  # [rad/s] more than this from side to side is felt
SWAYS = 8  # times in a drive ...
SHARE = 0.1  # ... and of its commands


def praise_of(recordings: Sequence[Recording]) -> str:
    """Say in numbers what the runs of a program with full marks show."""
    heard = sum(len(recording.delivered) for recording in recordings)
    said = (
        f"What was good: in {_count(len(recordings), 'run')} with {heard:,} messages nothing was "
        "missing, late or wrong."
    )
    drives = [each for each in recordings if _way(each) >= DRIVE]
    if not drives:
        return said
    said += f" In {_count(len(drives), 'drive')} the robot went {sum(map(_way, drives)):.0f} m"
    nearest = min(drives, key=lambda each: float(each.truth.clearance.min()))
    kept = float(nearest.truth.clearance.min())
    if kept >= FARTHEST or any(each.truth.contact.any() for each in drives):
        return f"{said}."
    return f"{said} and kept {kept:.2f} m from everything, or more ({nearest.name})."


def remarks_on(recordings: Sequence[Recording]) -> Iterator[str]:
    """Yield remarks on the program, a sentence each."""
    notes = (note for recording in recordings for note in recording.notes)
    for note in dict.fromkeys(Note(n.kind, n.about, n.line) for n in notes if n.kind == "imports"):
        yield f"{note.line} imports {note.about} and never uses it."
    said = (line.text for each in recordings for line in each.log if line.level == "stderr")
    for slip in dict.fromkeys(filter(None, map(said_in, said))):
        yield sentences(f"Line {slip.line}: {slip.text}")
    for recording in recordings:
        if (speed := _kept_at_the_end(recording)) is not None:
            yield (
                f"After Ctrl-C in {recording.name} no zero Twist came: a robot that hears nothing "
                f"more may keep the last command, {speed:.2f} m/s. Exercise 1's main shows how to "
                "stop it."
            )
    swaying = max(recordings, key=_sways, default=None)
    if swaying is not None and (times := _sways(swaying)):
        yield (
            f"In {swaying.name} the commands turned the robot from one side straight to the other "
            f"{times} times. A real one shakes: is the gain too large, or an angle in degrees?"
        )


def _sways(recording: Recording) -> int:
    """Return how often a drive went from one turn straight into its opposite; 0 if seldom."""
    turns = recording.twists().values[:, -1:].ravel()
    before, after = turns[:-1], turns[1:]
    opposite = (np.minimum(abs(before), abs(after)) > TURNS) & (before * after < 0)
    times = int(opposite.sum())
    often = times >= max(SWAYS, SHARE * len(turns))
    return times if often and _way(recording) >= DRIVE else 0


def _kept_at_the_end(recording: Recording) -> float | None:
    """Return the speed of the last command [m/s] if it drives, and no stop follows Ctrl-C."""
    commands = recording.twists().values
    if recording.ending is None or not len(commands) or np.abs(commands[-1]).max() < STANDS:
        return None
    after = views.twists(m for m in recording.ending.published if m.topic == CMD_VEL_TOPIC).values
    stops = len(after) and np.abs(after[-1]).max() < STANDS
    return None if stops else float(commands[-1][0])


def _way(recording: Recording) -> float:
    """Return how far the robot drove [m]."""
    truth = recording.truth
    return float(np.hypot(np.diff(truth.x), np.diff(truth.y)).sum())


def _count(count: int, what: str) -> str:
    return f"{count} {what}{'s' * (count != 1)}"
