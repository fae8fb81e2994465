"""What a node makes of plain readings, right or wrong: a mistake is named, and paid for, once.

`silent_until_ten`, `one_speed_per_reading`, `closing_speed`, `forgets_old` and `uses_stamps` judge
a node's habits. All other checks take them as given: whether it looks ahead, or empties its memory,
shows in its numbers whatever their unit is, if they follow a rule at all. The two that judge when
it speaks see all plain readings but those of `STAMPS`: what is taken as given there is paid for.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from grader.exercises.trend_memory.contract import (
    MEMORY_SIZE,
    RIGHT,
    Law,
    Step,
    closing_speed,
)

APPROACH, CHANGES, STAMPS = "trend_approach", "trend_changes", "trend_stamps"
PLAIN = (APPROACH, CHANGES, STAMPS)  # scenarios that show a node's habits
SMALL = "trend_small_stamps"  # shows them where stamps of 1.7e9 s leave no digits for any
_LAWS = ("slope", "first and last", "time over distance", "whole seconds")
_ROUNDED = (RIGHT._replace(grain=0.01), RIGHT._replace(grain=0.1))
MANY = 10  # tolerances, by which numbers differ
_MOST = 500  # numbers: a node that says more has no rule worth a search
_LONGEST = 25  # readings: more than any bench shows at once


@dataclass(frozen=True)
class Habits:
    """What a node does with plain readings."""

    law: Law | None = RIGHT  # None: its numbers follow no rule that is known here
    early: bool = False  # it speaks before the tenth reading
    regular: bool = True  # one closing speed follows each reading from then on


def in_seconds(law: Law) -> Law:
    """Return what a law becomes when the time is that of the stamps."""
    return RIGHT if law.name == "whole seconds" else law._replace(counts=False)


Shown = tuple[tuple[Step, tuple[float, ...]], ...]  # steps, and the closing speeds after each


def habits_of(shown: Mapping[str, Shown]) -> Habits:
    """Return the habits that a node showed in the plain scenarios, by their names."""
    plain = (*shown.get(APPROACH, ()), *shown.get(CHANGES, ()))
    said = _said(plain)
    found = (law for law in _laws(said) if _follows(law, said) and _tells(law, said))
    law = next(found, None)
    if law is None:
        law = next((rough for rough in _ROUNDED if _is_rounded(said, rough)), None)
    if law is None and said and _follows(RIGHT, said[:1]):
        law = RIGHT  # once at least
    early = any(step.silent and values for step, values in plain)
    regular = all(len(values) == 1 for step, values in plain if step.spoken)
    late = _said(shown.get(STAMPS, ()))
    if law and late and not _follows(law, late):
        counting = law._replace(counts=True)
        law = counting if _follows(counting, late) else law
    return Habits(law, early, regular)


def _said(shown: Shown) -> list[tuple[Step, float]]:
    return [(step, value) for step, values in shown if step.spoken for value in values]


def _laws(said: list[tuple[Step, float]]) -> Iterator[Law]:
    """Return the laws that may be behind what was said, likely ones first."""
    if not 2 <= len(said) <= _MOST:  # the first one tells the scale, and nothing more
        return
    step, value = said[0]
    kept = [(n, False) for n in range(2, _LONGEST)]
    for name in _LAWS:
        for keeps, first in ((MEMORY_SIZE, False), (None, False), (MEMORY_SIZE, True), *kept):
            law = Law(name, 1.0, keeps, first)
            yield law
            wanted = closing_speed(step.readings, law)
            if wanted and value:
                yield law._replace(scale=value / wanted)


def _follows(law: Law, said: list[tuple[Step, float]]) -> bool:
    """Tell whether all that was said is what this law gives."""
    return all(
        abs(closing_speed(step.readings, law) - value) <= law.tolerance for step, value in said
    )


def _is_rounded(said: list[tuple[Step, float]], law: Law) -> bool:
    """Tell whether all that was said are the right numbers, rounded to this law's grain."""
    if not 2 <= len(said) <= _MOST or not _follows(law, said):
        return False
    whole = all(abs(value / law.grain - round(value / law.grain)) < 1e-6 for _, value in said)
    return whole and _tells(law, said)


def _tells(law: Law, said: list[tuple[Step, float]]) -> bool:
    """Tell whether the law gives more than one number: else it says nothing of the readings."""
    wanted = [closing_speed(step.readings, law) for step, _ in said]
    return max(wanted) - min(wanted) > MANY * law.tolerance
