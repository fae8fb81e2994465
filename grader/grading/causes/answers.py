"""What a node's answers have in common: late by a scan, silent, kept, filtered, cut, of two minds.

The exercise's oracle says what each occasion asks for. A look speaks only if it explains *all*
answers of a run and the right ones don't, so that a node that errs otherwise reads nothing.
"""

from __future__ import annotations

import itertools
import math
from collections import Counter
from collections.abc import Callable, Sequence
from typing import NamedTuple

from grader.checks.case import Case, among
from grader.checks.commands import spell
from grader.course.exercises import Exercise
from grader.exercises import contract_of, oracle_of
from grader.grading.causes.cause import ByName, Cause, Failed
from grader.recording import Recording
from sim.messages import CMD_VEL_TOPIC

MIN_CASES = 6  # to see what they have in common
TELLING = 3  # of them, where the explanation and the contract differ
MOST_LATE = 10  # scans
NEAR = 2e-3  # [m/s] and the like
LENGTHS = (3, 5, 7, 9)  # of a median filter
SHARE = 0.02  # by which a filter's share may vary


class Row(NamedTuple):
    """An occasion, in the field that the exercise asks for first."""

    case: Case
    said: float  # nan: nothing yet
    right: float  # the one number that is allowed; nan if there are several


def cause_of_answers(exercise: Exercise, failed: Sequence[Failed], trials: ByName) -> Cause | None:
    """Return the cause that all answers of the first failed run have in common."""
    recording = trials.get(failed[0].scenario or "")
    if recording is None or not recording.outcome.completed or recording.live is not None:
        return None
    if text := publishers_of(recording):
        return Cause.of(exercise, text, failed, replaces_help=True, own_hint=False)
    if failed[0].kind == "field":  # the core passes: not the answers' law is wrong
        return None
    try:
        cases = oracle_of(exercise)(recording)
    except Exception:  # what the node sent can't be read: the check says so
        return None
    period = bool(contract_of(exercise).period)
    text = seen_in(cases, recording.name, period=period)
    return Cause.of(exercise, text, failed, replaces_help=True, own_hint=False) if text else None


def seen_in(cases: Sequence[Case], run: str, *, period: bool = False) -> str:
    """Say in a sentence what all answers have in common; "" if nothing.

    `period`: a timer commands, so that a zero that stays may say that nothing newer has come.
    """
    name, rows = _rows(cases)
    wrong = [row for row in rows if not _fits(row, row.case)]
    if len(rows) < MIN_CASES:
        return ""
    if not wrong:
        return _silent(rows, run)
    if len(wrong) < TELLING:
        return ""
    looks: tuple[Callable[[Sequence[Row]], str], ...] = (_late, _cut, _kept, _median, _low_pass)
    zero = period and abs(rows[-1].said) <= NEAR
    for look in looks:
        if not (look is _kept and zero) and (text := look(rows)):
            return f"in {run} {text.format(name=name)}"
    return ""


def _rows(cases: Sequence[Case]) -> tuple[str, list[Row]]:
    """Return the field that most cases ask for first, and its rows in order."""
    fields = Counter(
        next(iter(case.allowed))
        for case in cases
        if case.allowed and not isinstance(next(iter(case.allowed.values())), frozenset)
    )
    if not fields:
        return "", []
    name = fields.most_common(1)[0][0]
    rows = []
    for case in sorted((case for case in cases if name in case.allowed), key=lambda case: case.at):
        said, allowed = case.said.get(name), case.allowed[name]
        one = math.nan
        if not isinstance(allowed, frozenset) and len({n for pair in allowed for n in pair}) == 1:
            one = allowed[0][0]
        rows.append(Row(case, float(said) if isinstance(said, float | int) else math.nan, one))
    return name, rows


def _fits(row: Row, case: Case) -> bool:
    """Return whether an answer is allowed in a case."""
    return among(row.said, next(iter(case.allowed.values())), NEAR)


def _late(rows: Sequence[Row]) -> str:
    """The right answer, to an earlier occasion."""
    for late in range(1, MOST_LATE + 1):
        pairs = [(row, before.case) for before, row in zip(rows, rows[late:], strict=False)]
        pairs = [(row, case) for row, case in pairs if not math.isnan(row.said)]
        if len(pairs) < MIN_CASES or not all(_fits(row, case) for row, case in pairs):
            continue
        first = next((row for row, _ in pairs if not _fits(row, row.case)), None)
        if first is None or sum(not _fits(row, row.case) for row, _ in pairs) < TELLING:
            return ""
        which = "the scan before it" if late == 1 else f"the scan {late} before it"
        if late > 1 and _median(rows):  # of a rise, a median of 2 k + 1 is k late
            which += f", which is also the median of what the last {2 * late + 1} ask for"
        return (
            f"each of {len(pairs)} answers is the right one for {which}: at {first.case.at:.2f} s "
            f"{{name}} is {spell(first.said)}. Is the command published before the new one is "
            "made, or does it come from a list or a filter of earlier readings?"
        )
    return ""


def _silent(rows: Sequence[Row], run: str) -> str:
    """Right answers, but only where they change."""
    mute = [i for i, row in enumerate(rows) if row.case.count == 0]
    spoken = [i for i, row in enumerate(rows) if row.case.count == 1]
    if len(mute) < TELLING or len(mute) + len(spoken) < len(rows) or 0 in mute:
        return ""
    same = [i for i in range(1, len(rows)) if abs(rows[i].said - rows[i - 1].said) <= NEAR]
    if same != mute:
        return ""
    return (
        f"in {run} nothing is published in {len(mute)} of {len(rows)} scans, and in just these the "
        f"answer is the same as before, first at {rows[mute[0]].case.at:.2f} s. Does the node "
        "publish only what is new? Publish once for each scan."
    )


def _cut(rows: Sequence[Row]) -> str:
    """The right answer without its decimals."""
    known = [row for row in rows if not math.isnan(row.right)]
    telling = [row for row in known if abs(row.right - math.trunc(row.right)) > NEAR]
    values = {round(row.right, 3) for row in telling}
    if len(telling) < MIN_CASES or len(values) < TELLING:
        return ""
    if not all(abs(row.said - math.trunc(row.right)) <= NEAR for row in known):
        return ""
    if len({math.trunc(row.right) for row in known}) < 2:  # always 0 has other reasons
        return ""
    row = telling[0]
    return (
        f"each of {len(known)} answers is the right one without its decimals: at {row.case.at:.2f} "
        f"s {{name}} is {spell(row.said)}, not {spell(row.right)}. Is there an int(…) or a // in "
        "its way? float(…) keeps the decimals."
    )


def _kept(rows: Sequence[Row]) -> str:
    """Right up to a moment, and the same from there on."""
    last = len(rows) - 1
    while last > 0 and abs(rows[last - 1].said - rows[-1].said) <= NEAR:
        last -= 1
    before, after = rows[: last + 1], rows[last + 1 :]
    wrong = [row for row in after if not _fits(row, row.case)]
    if len(wrong) < TELLING or len({round(row.said, 3) for row in before}) < TELLING:
        return ""
    if not all(_fits(row, row.case) for row in before):
        return ""
    return (
        f"{len(before)} answers are right, and from {rows[last].case.at:.2f} s on {{name}} is "
        f"always {spell(rows[-1].said)}, the answer to the scan then, whatever comes. Does "
        "something that is set there never change back?"
    )


def _median(rows: Sequence[Row]) -> str:
    """The median of the last scans' right answers."""
    for length in LENGTHS:
        pairs = [
            (row, sorted(each.right for each in rows[i - length + 1 : i + 1])[length // 2])
            for i, row in enumerate(rows)
            if i >= length - 1
            and not any(math.isnan(r.right) for r in rows[i - length + 1 : i + 1])
        ]
        if len(pairs) >= MIN_CASES and all(abs(row.said - middle) <= NEAR for row, middle in pairs):
            wrong = [row for row, _ in pairs if not _fits(row, row.case)]
            if len(wrong) < TELLING:
                return ""
            first = wrong[0]
            return (
                f"each of {len(pairs)} answers is the median of what the last {length} scans ask "
                f"for: at {first.case.at:.2f} s {{name}} is {spell(first.said)}, not "
                f"{spell(first.right)}. Is there a filter, or a list of the last readings? Each "
                "scan is answered by itself."
            )
    return ""


def _low_pass(rows: Sequence[Row]) -> str:
    """Always the same share of the way from the last answer to the right one, or the same step."""
    shares, steps = [], []
    for before, row in itertools.pairwise(rows):
        way, gone = row.right - before.said, row.said - before.said
        if math.isnan(way) or abs(way) <= NEAR:
            if abs(row.said - row.right) > NEAR:
                return ""
            continue
        shares.append(gone / way)
        if not _fits(row, row.case):
            steps.append(gone)
    if len(steps) < TELLING:
        return ""
    first = next(r for r in rows[1:] if not _fits(r, r.case) and not math.isnan(r.right))
    seen = f"at {first.case.at:.2f} s {{name}} is {spell(first.said)}, not {spell(first.right)}"
    if min(shares) > SHARE and max(shares) < 1 - SHARE and max(shares) - min(shares) <= SHARE:
        return (
            f"each answer goes {100 * shares[0]:.0f} % of the way from the last one to the right "
            f"one: {seen}. Is there a low-pass filter? Each scan is answered by itself."
        )
    sizes = [abs(step) for step in steps]
    if min(sizes) > NEAR and max(sizes) - min(sizes) <= NEAR and all(0 <= s <= 1 for s in shares):
        return (
            f"the answers change by {spell(max(sizes))} at most from one scan to the next: {seen}. "
            "Is there a limit to how fast the speed changes? The table asks for the speed at once."
        )
    return ""


def publishers_of(recording: Recording) -> str:
    """Several publishers on the robot's topic, or one for each message."""
    every = [e for e in recording.ends if (e.kind, e.topic) == ("publisher", CMD_VEL_TOPIC)]
    ends = [e for e in every if (e.node, e.process) == (every[0].node, every[0].process)]
    commands = len(recording.twists().t)
    if len(ends) < 2 or (len(ends) == 2 and commands < 1.5 * len(recording.scans())):
        return ""
    often = "" if len(ends) == 2 else "Is one made with each message? "
    return (
        f"the node has {len(ends)} publishers on {CMD_VEL_TOPIC} in {recording.name}, and "
        f"{commands} commands came for {len(recording.scans())} scans. {often}Make one, in the "
        "constructor: a new one reaches nobody until it is discovered, and two contradict each "
        "other."
    )
