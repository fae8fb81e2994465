"""Causes that a trial's end shows: an exception, a hang, a node that is not wired."""

from __future__ import annotations

import re
from collections.abc import Sequence

from grader.course.exercises import Exercise
from grader.grading.causes.cause import ByName, Cause, Failed, hint_on, sentences, shortened
from grader.recording import Outcome, death_of

UNWIRED = re.compile(r"there is (no|an?) \w+ (of \S+ )?on /|the (publisher|subscription) o[nf] /")
UNREAD_FILE = (
    "{} ends at once, because {} can't be read: {}. Look at that line and the next: below the "
    "node's name stands ros__parameters:, two spaces deeper than it, and each parameter below "
    "ros__parameters:, two spaces deeper again."
)
WIRED = "wiring"  # in the names of the checks that every other one needs


def cause_of_end(exercise: Exercise, failed: Sequence[Failed], trials: ByName) -> Cause | None:
    """Return why the first node that ended early did so; or the endpoint that is not wired."""
    for check in failed:
        recording = trials.get(check.scenario or "")
        if recording is not None and not recording.outcome.completed and check.where:
            return _cause_of(exercise, recording.outcome, check)
    first = failed[0]
    if (run := trials.get(first.scenario or "")) is not None and run.outcome.completed:
        for note in run.notes:
            line = re.search(r"\(line (\d+), in ", note.more)
            if note.kind == "ended" and line:
                where = f"line {line[1]} of {note.about}"
                text = f"{note.about} ended at {note.time / 1e9:.1f} s: {note.more}"
                if wrong := re.search(r"file: '.{0,20}?([\w.]+\.yaml)'\. Error: ([^,]+)", text):
                    where, text = "", UNREAD_FILE.format(note.about, *wrong.groups())
                return Cause.of(exercise, text, [first], where=where)
    if WIRED in first.id or (first.kind == "core" and _ended(first, trials)):
        return Cause.of(exercise, _said(first), [first], where=first.where)
    if UNWIRED.match(first.message):  # its checks' hints are about what it would say there
        return Cause.of(exercise, _said(first), [first], own_hint=False)
    return None


def _ended(check: Failed, trials: ByName) -> bool:
    recording = trials.get(check.scenario or "")
    return recording is not None and not recording.outcome.completed


def _said(check: Failed) -> str:
    return sentences(check.message, check.help)


def _cause_of(exercise: Exercise, outcome: Outcome, check: Failed) -> Cause:
    death = death_of(outcome.detail)
    if death is None:
        return Cause.of(exercise, _said(check), [check], where=check.where)
    where = str(death.frames[0]) if death.frames else ""
    subject = "The node" if death.in_callback else "The program"
    if death.said:
        text = f"{subject} dies in {death.place}: {shortened(death.said)}"
    else:
        known = not death.loop or death.loop in check.help
        loop = "" if known else f", in the loop of {death.loop}"
        waits = outcome.kind == "stuck"
        text = f"{subject} {'waits for good' if waits else 'hangs'} in {death.place}{loop}"
    advice = "" if check.help.startswith("Look at line ") else check.help  # which stands beside it
    said = sentences(text, advice)
    hint = None if "slice" in check.help else hint_on(exercise, death.said)
    return Cause(said, check.kind, where, hint, check=check.id)
