"""A case: a moment that asks a node for an answer, with the answers allowed and the one given."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

from grader.checks.commands import Answer, spell
from grader.recording import Recording

Interval = tuple[float, float]  # the least and the greatest
Allowed = tuple[Interval, ...] | frozenset[str]  # any of these numbers, or of these words
Said = float | str
MIN_ANSWERS = 3  # to see that they err alike
NEAR_ZERO = 1e-3
HUGE = 1e13  # a factor that is no slip of units: a second has 1e12 picoseconds
ROUNDED = 0.01  # of a factor
ASKS = "asks for "  # a field, in a list of tags


@dataclass(frozen=True)
class Case:
    """One case.

    Fields are named as in the message: `linear.x` of a Twist, `data` of a Float64, `reason`.
    """

    at: float  # [s]
    what: str  # in a student's words: "a wall 0.42 m ahead"
    tags: frozenset[str] = frozenset()  # under which checks ask for it
    allowed: Mapping[str, Allowed] = field(default_factory=dict)  # by field; none: silence
    said: Mapping[str, Said] = field(default_factory=dict)  # in force at the end; none: nothing yet
    count: int = 1  # messages that were sent in this case

    @cached_property
    def rounded(self) -> tuple[tuple[str, Said], ...]:
        """The answer, to three decimals, in order of the fields."""
        return tuple(
            (name, round(value, 3) if isinstance(value, float) else value)
            for name, value in sorted(self.said.items())
        )

    def wrong(self, tolerance: float = 0.0) -> str:
        """Return the first field with a wrong answer; empty if the answer is right."""
        for name, allowed in self.allowed.items():
            if not among(self.said.get(name), allowed, tolerance):
                return name
        return ""


def answered(answer: Answer, allowed: Mapping[str, Allowed], *tags: str, what: str = "") -> Case:
    """Return the case of a scan, with the answer in the fields that are asked for."""
    return Case(
        at=answer.scan.t,
        what=what or answer.what,
        tags=frozenset({*answer.tags, *tags}),
        allowed=allowed,
        said=answer.said(*allowed),
        count=answer.count,
    )


Oracle = Callable[[Recording], Sequence[Case]]


@dataclass(frozen=True, eq=False)
class Runs(Sequence[Recording]):
    """The recordings of a check's scenarios, in the order of its mark."""

    recordings: Sequence[Recording]
    oracle: Oracle  # the exercise's `cases`
    exercise: str = ""  # its slug

    def __getitem__(self, key: Any) -> Any:
        """Return a recording, by its place or its scenario's name."""
        if isinstance(key, str):
            return next(run for run in self.recordings if run.name == key)
        return self.recordings[key]

    def __len__(self) -> int:
        """Return how many there are."""
        return len(self.recordings)

    def only(self, *names: str) -> Runs:
        """Return the runs in these scenarios."""
        return self.of([run for run in self.recordings if run.name in names])

    def driven(self) -> Runs:
        """Return the runs of closed loops: what a bench shows does not depend on the commands."""
        return self.of([run for run in self.recordings if not run.scenario.bench_scans])

    def benches(self) -> Runs:
        """Return the runs in which a bench says what the lidar sees."""
        return self.of([run for run in self.recordings if run.scenario.bench_scans])

    def of(self, recordings: Sequence[Recording]) -> Runs:
        """Return these recordings, with the same oracle."""
        return replace(self, recordings=recordings)

    def cases(self, *tags: str) -> Iterator[tuple[Recording, Case]]:
        """Yield the cases with one of these tags (all if none is named), and their recordings."""
        for recording in self.recordings:
            cases, places = self._judged(recording)
            named = sorted({place for tag in tags for place in places.get(tag, ())})
            for case in (cases[place] for place in named) if tags else cases:
                yield recording, case

    def asking(self, fields: Iterable[str]) -> Iterator[tuple[Recording, Case]]:
        """Yield the cases that ask for one of these fields, and their recordings."""
        return self.cases(*(ASKS + name for name in fields))

    def _judged(self, recording: Recording) -> tuple[Sequence[Case], Mapping[str, list[int]]]:
        """Return a recording's cases, and the places of each tag and field; found once."""
        if self.oracle not in recording.judged:
            cases, places = self.oracle(recording), defaultdict[str, list[int]](list)
            for place, case in enumerate(cases):
                for tag in (*case.tags, *(ASKS + name for name in case.allowed)):
                    places[tag].append(place)
            recording.judged[self.oracle] = cases, places
        found: tuple[Sequence[Case], Mapping[str, list[int]]] = recording.judged[self.oracle]
        return found


def exactly(*numbers: float) -> tuple[Interval, ...]:
    """Return an allowance for exactly these numbers."""
    return tuple((number, number) for number in numbers)


def spell_allowed(allowed: Allowed, unit: str = "") -> str:
    """Return an allowance in words: `0.00 m/s or 0.15 m/s`, `0.10 to 0.30 m/s`."""
    if not allowed:
        return "something else"
    unit = f" {unit}" if unit else ""
    if isinstance(allowed, frozenset):
        return " or ".join(f"“{word}”" for word in sorted(allowed))
    spelled = ((spell(low), spell(high)) for low, high in sorted(allowed))
    spans = dict.fromkeys(low if low == high else f"{low} to {high}" for low, high in spelled)
    return " or ".join(f"{span}{unit}" for span in spans)


def wrong_unit(cases: Sequence[Case], field: str) -> str:
    """Say that a field is wrong by the same power of ten in all cases; "" if it is not."""
    pairs = [(case.said.get(field), case.allowed[field]) for case in cases if field in case.allowed]
    factors = [
        said / right[0]
        for said, allowed in pairs
        for right in list(allowed)[:1]
        if isinstance(said, float) and isinstance(right, tuple) and abs(right[0]) > NEAR_ZERO
    ]
    if len(factors) < max(MIN_ANSWERS, len(pairs) / 2):
        return ""
    if not all(1.0 / HUGE < each < HUGE for each in factors):  # NaN, too
        return ""
    power = round(math.log10(factors[0]))
    if not power or any(abs(each / 10.0**power - 1.0) > ROUNDED for each in factors):
        return ""
    size = f"{10 ** abs(power):,} times too {'big' if power > 0 else 'small'}"
    return (
        f"{field} is {size} in each of {len(factors)} answers. Is there a slip of units, such as "
        "seconds, milliseconds and nanoseconds?"
    )


def among(said: Said | None, allowed: Allowed, tolerance: float) -> bool:
    """Return whether an answer is allowed; NaN never is."""
    if isinstance(allowed, frozenset):
        return said in allowed
    if not isinstance(said, float | int) or math.isnan(said):
        return False
    return any(low - tolerance <= said <= high + tolerance for low, high in allowed)
