"""What the failures of several checks on one answer have in common.

A check's help is about its own subject, such as what is behind the robot. If the check that is
named after the wrong field fails, too, its help is given instead. If checks of other tasks fail on
that field, the subject is not what went wrong: what the answers have in common is said.
"""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Sequence
from typing import NamedTuple

from grader.checks.case import Case, Said, among, spell_allowed, wrong_unit
from grader.checks.commands import spell
from grader.checks.predictions import CALLED, OTHERWISE, PREDICT
from grader.course.exercises import Exercise
from grader.exercises import oracle_of
from grader.grading.causes.cause import ByName, Cause, Failed, hint_for, sentences
from rclpy_virtual_time import LogLine

AT_ONCE = 0.05  # [s]
MAX_LINE = 160  # [characters]
TOLERANCE = 0.01  # of a factor
NEAR = 2e-3  # [m/s] and the like
MIN_ANSWERS = 6
FEW = 3  # checks
MOST_AT_FIRST = 30  # answers of a run
WRONG_SHARE = 0.9  # of the wrong answers
NUMBER = re.compile(r"([\w.]+) = (-?\d+(?:\.\d+)?)(?![\w.])(?! [^ ]+ or| or| to)")
TOPIC = re.compile(r"/(\w+)")
MODEL = {  # how it was asked: what is said of it
    f"not {CALLED}": "not asked about the scan. Does the callback get as far as predict?",
    OTHERWISE: "asked about other features than the scan's. Log the five, and compare each with "
    "its definition: which beams, which order, which unit?",
}
LOG = (
    "Log what you decide on. Is it the same each time? Then look at where it is made from what "
    "comes in. If not: does the decision use it, and is the result published?"
)


class _Row(NamedTuple):
    """An answer in one field."""

    case: Case
    said: Said | None
    right: float  # nan: it is no one number

    @property
    def wrong(self) -> bool:
        return not among(self.said, next(iter(self.case.allowed.values())), NEAR)


def cause_of_several(exercise: Exercise, failed: Sequence[Failed], trials: ByName) -> Cause | None:
    """Return what the checks of several tasks that fail on one field of the answers show."""
    if text := _signs(failed):
        return Cause.of(exercise, text, failed, replaces_help=True, own_hint=False)
    field = asked(failed[0])
    same = [check for check in failed if field and asked(check) == field]
    if text := _units(exercise, failed[0], field, trials):
        return Cause.of(exercise, text, same, replaces_help=True)
    names = {field, *TOPIC.findall(failed[0].message)}
    named = [c for c in failed if same and {c.id, c.id.removesuffix("s")} & names]
    if named and failed[0] not in named:
        check = named[0]
        return Cause.of(
            exercise, sentences(check.message, check.help), [check, *same],
            hint=hint_for(exercise, [check]), replaces_help=True,
        )  # fmt: skip
    if named or len(same) < FEW or len({check.task for check in same}) < 2:
        return None  # of two, each may have a mistake of its own: their own helps stand
    names = {check.scenario or "" for check in same}
    runs: list[list[_Row]] = []
    log: list[LogLine] = []
    for name, run in ((name, run) for name, run in trials.items() if name in names):
        log += run.log if name == failed[0].scenario else ()
        try:
            runs.append(_rows(oracle_of(exercise)(run), field))
        except Exception:  # what the node sent can't be read: the check says so
            continue
    rows = [row for each in runs for row in each]
    text = _at_first(runs, field) or in_common(rows, field, reason_in(log, failed[0].time))
    return Cause.of(exercise, text, same, replaces_help=True, own_hint=False) if text else None


def asked(check: Failed) -> str:
    """Return the field whose answer a check found wrong; "" if the check is not about answers."""
    field, equals, _ = check.expected.partition(" = ")
    return field if equals else ""


def reason_in(log: Sequence[LogLine], time: float | None) -> str:
    """Return the node's warning at a failed check; "" if there is none."""
    for line in log:
        at = time is not None and abs(line.t - time) <= AT_ONCE
        if at and line.level in ("warn", "error", "fatal"):
            return " ".join(line.text.split())[:MAX_LINE]
    return ""


def in_common(rows: Sequence[_Row], field: str, reason: str = "") -> str:
    """Return what the wrong answers have in common, in a sentence or two.

    `reason`: what the node's log says at the first of them.
    """
    wrong = [row for row in rows if row.wrong]
    if len(rows) < MIN_ANSWERS or not wrong:
        return ""
    asked_of_model = Counter(str(row.case.said.get(PREDICT, CALLED)) for row in wrong)
    how, often = asked_of_model.most_common(1)[0]
    if how != CALLED and often >= WRONG_SHARE * len(wrong):
        return (
            f"{len(wrong)} of {len(rows)} answers are wrong, and for {often} of these the model is "
            f"{MODEL[how]}"
        )
    said = Counter(_shown(row.said) for row in rows)
    (usual, times), *others = said.most_common()
    if not others:
        seen = f"{field} is {usual} in all {times} answers"
        if reason:
            return f"{seen}, and the node's log gives a reason: “{reason}”. Can that be right?"
        return f"{seen}, whatever comes. {LOG}"
    if text := _scaled(rows, field):
        return text
    pairs = Counter(
        (_shown(row.said), spell_allowed(next(iter(row.case.allowed.values())))) for row in wrong
    )
    kinds = [
        f"{'once' if n == 1 else f'{n} times'} {is_} where {right} is right"
        for (is_, right), n in pairs.most_common(2)
    ]
    left = len(wrong) - sum(n for _, n in pairs.most_common(2))
    rest = f", {left} otherwise" if left else "; the others are right"
    first = wrong[0].case
    return (
        f"{len(wrong)} of {len(rows)} answers have a wrong {field}: {', '.join(kinds)}{rest}. The "
        f"first is at {first.at:.2f} s, to {first.what}."
    )


def _at_first(runs: Sequence[Sequence[_Row]], field: str) -> str:
    """Say that only the first answers of each run are wrong, and all alike."""
    wrong = [[i for i, row in enumerate(each) if row.wrong] for each in runs]
    first = max((each[-1] + 1 for each in wrong if each), default=0)
    said = {_shown(row.said) for each in runs for row in each[:first]}
    later = sum(len(each[first:]) for each in runs)
    if first < 2 or first > MOST_AT_FIRST or len(said) != 1 or later < MIN_ANSWERS:
        return ""
    return (
        f"{field} is {said.pop()} in the first {first} answers of each run, whatever comes, and "
        f"right in the {later} that follow. Does the node wait for some messages, or for a filter "
        "to fill? Each one counts, from the first on."
    )


def _signs(failed: Sequence[Failed]) -> str:
    """Say that the numbers of several checks are right but for their sign."""
    pairs = [(NUMBER.match(check.expected), NUMBER.match(check.actual)) for check in failed]
    numbers = [(right, said) for right, said in pairs if right and said and right[1] == said[1]]
    turned = [right for right, said in numbers if float(right[2]) == -float(said[2]) != 0.0]
    if len(turned) < FEW or len(turned) < len(numbers):
        return ""
    negative = all(float(right[2]) < 0.0 for right in turned)
    ask = "does abs(…) take the sign away?" if negative else "is a minus one too many or too few?"
    return (
        f"in {len(turned)} checks the number has the right size and the wrong sign, as where "
        f"{turned[0][0]} is right: {ask}"
    )


def _units(exercise: Exercise, check: Failed, field: str, trials: ByName) -> str:
    """Say that a field of all answers in one run is wrong by a power of ten."""
    run = trials.get(check.scenario or "")
    try:
        return wrong_unit(oracle_of(exercise)(run), field) if run is not None and field else ""
    except Exception:  # what the node sent can't be read: the check says so
        return ""


def _scaled(rows: Sequence[_Row], field: str) -> str:
    """Say that all answers are wrong by one factor."""
    telling = [row for row in rows if abs(row.right) > TOLERANCE and isinstance(row.said, float)]
    factors = [row.said / row.right for row in telling if isinstance(row.said, float)]
    if len(factors) < MIN_ANSWERS or len({round(row.right, 2) for row in telling}) < 3:
        return ""
    least, most = min(factors), max(factors)
    if not most - least <= TOLERANCE * abs(most) or abs(most - 1.0) <= TOLERANCE:
        return ""
    what = "has the wrong sign" if abs(most + 1.0) <= TOLERANCE else f"is {most:.4g} times too big"
    return f"each of {len(factors)} answers {what}: {field} is {_shown(telling[0].said)}, not " + (
        f"{spell(telling[0].right)}. Is there a slip of units, or of a sign?"
    )


def _rows(cases: Sequence[Case], field: str) -> list[_Row]:
    rows = []
    for case in cases:
        if next(iter(case.allowed), "") == field:
            allowed = case.allowed[field]
            right = math.nan
            if not isinstance(allowed, frozenset) and len({n for p in allowed for n in p}) == 1:
                right = allowed[0][0]
            rows.append(_Row(case, case.said.get(field), right))
    return rows


def _shown(said: Said | None) -> str:
    return "nothing" if said is None else spell(said) if isinstance(said, float) else f"“{said}”"
