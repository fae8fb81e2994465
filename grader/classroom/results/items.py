"""Item analysis: what a class's results say about the exercise's checks.

Difficulty index and point-biserial discrimination are those of classical test theory (Crocker &
Algina, "Introduction to Classical and Modern Test Theory", chapters 4 and 14).
"""

from __future__ import annotations

import re
import statistics
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from grader.classroom.marks import Check, checks_of, points_of
from grader.classroom.row import StoredResult
from grader.lms.book import Task
from grader.lms.clean import one_line
from grader.report.facts import UNJUDGED

BINS = 10
ENOUGH = 10  # submissions; with fewer, the indices are mostly chance
WEAK, GOOD = 0.2, 0.4  # discrimination, Ebel's rules of thumb
HARD, EASY = 0.25, 0.95  # difficulty index

_NUMBER = re.compile(r"[-\N{MINUS SIGN}]?\d+(?:[.,]\d+)*")


@dataclass(frozen=True)
class Item:
    """One check, over a whole class."""

    id: str
    title: str
    kind: str  # "core" or "field"
    judged: int  # submissions in which it passed, failed or was skipped
    failed: int
    skipped: int
    difficulty: float | None  # share of the judged that passed
    discrimination: float | None  # point-biserial with the rest of the score
    often: str  # the most frequent failure message; "" if none occurs twice
    times: int  # how often it occurs
    hint: str

    @property
    def counts(self) -> str:
        """How many did not pass."""
        said = [f"{self.failed} failed" if self.failed else ""]
        said += [f"{self.skipped} skipped" if self.skipped else ""]
        return ", ".join(filter(None, said)) or "none"


@dataclass(frozen=True)
class Distribution:
    """The scores of a class in one exercise [points]."""

    scores: tuple[float, ...]  # ascending
    bins: tuple[int, ...]  # submissions in each tenth of the points
    full: int  # with full marks
    points: float

    @property
    def mean(self) -> float | None:
        return statistics.fmean(self.scores) if self.scores else None

    @property
    def median(self) -> float | None:
        return statistics.median(self.scores) if self.scores else None

    @property
    def quartiles(self) -> tuple[float, float] | None:
        """Lower and upper quartile; None for fewer than four scores."""
        if len(self.scores) < 4:
            return None
        low, _, high = statistics.quantiles(self.scores, n=4, method="inclusive")
        return low, high

    @property
    def in_words(self) -> str:
        """The bins, for a screen reader."""
        tenth = self.points / BINS
        found = [
            f"{count} from {i * tenth:g} to {(i + 1) * tenth:g}"
            for i, count in enumerate(self.bins)
            if count
        ]
        return ", ".join(found) or "none"


def distribution(results: Sequence[StoredResult], task: Task) -> Distribution:
    scores = sorted(p for p in map(points_of, results) if p is not None)
    bins = [0] * BINS
    for score in scores:
        bins[min(BINS - 1, int(BINS * score / task.points))] += 1
    full = sum(score >= task.points for score in scores)
    return Distribution(tuple(scores), tuple(bins), full, task.points)


def item_analysis(graded: Sequence[StoredResult]) -> list[Item]:
    """Return the analysis of every check of an exercise, in the order of the checks."""
    checks = [{str(check.get("id")): check for check in checks_of(result)} for result in graded]
    ids = list(dict.fromkeys(id_ for each in checks for id_ in each))
    return [_item(id_, [each[id_] for each in checks if id_ in each], checks) for id_ in ids]


def point_biserial(passed: Sequence[bool], rest: Sequence[float]) -> float | None:
    """Return the correlation between passing and the rest of the score; None if either is constant.

    The item itself is left out of the score ("corrected"), or it would correlate with itself.
    """
    if len(set(passed)) < 2 or len(set(rest)) < 2:
        return None
    return statistics.correlation([float(value) for value in passed], list(rest))


def _item(id_: str, all_of_it: list[Check], checks: list[dict[str, Check]]) -> Item:
    first = all_of_it[0]
    kind = "field" if first.get("kind") == "field" else "core"
    outcomes = Counter(str(check.get("outcome")) for check in all_of_it)
    # a field check is skipped if a core check failed, which says nothing about it
    counted = ("pass", "fail") if kind == "field" else ("pass", "fail", "skip")
    judged = sum(outcomes[outcome] for outcome in counted)
    difficulty = outcomes["pass"] / judged if judged else None
    discrimination = _discrimination(id_, checks) if kind == "core" else None
    often, times = _often([c for c in all_of_it if c.get("outcome") == "fail"])
    return Item(
        id=id_,
        title=one_line(first.get("title") or id_, 200),
        kind=kind,
        judged=judged,
        failed=outcomes["fail"],
        skipped=outcomes["skip"],
        difficulty=difficulty,
        discrimination=discrimination,
        often=often,
        times=times,
        hint=_hint(judged, difficulty, discrimination, outcomes["skip"]),
    )


def _discrimination(id_: str, checks: list[dict[str, Check]]) -> float | None:
    passed, rest = [], []
    for each in checks:
        if id_ not in each or each[id_].get("outcome") in UNJUDGED:
            continue
        passed.append(each[id_].get("outcome") == "pass")
        others = (check for name, check in each.items() if name != id_)
        rest.append(sum(float(check.get("points") or 0) for check in others))
    return point_biserial(passed, rest)


def _often(failed: list[Check]) -> tuple[str, int]:
    """Return the most frequent message and its count; messages may differ in their numbers."""
    messages = [one_line(check.get("message") or "", 220) for check in failed]
    forms = Counter(alike(message) for message in messages if message)
    if not forms:
        return "", 0
    form, times = max(forms.items(), key=lambda pair: (pair[1], pair[0]))
    if times < 2:
        return "", 0
    return min(message for message in messages if alike(message) == form), times


def alike(message: str) -> str:
    """Return what messages have in common that differ only in their numbers."""
    return _NUMBER.sub("#", one_line(message, 220))


def _hint(judged: int, p: float | None, r: float | None, skipped: int) -> str:
    """Say in plain words what the indices mean for the instructor."""
    if p is None:
        return "Judged in no submission."
    if judged < ENOUGH:
        return f"Only {judged} judged: too few to interpret."
    if r is not None and r < 0:
        return "Those who fail it do better elsewhere: look at the check and its wording."
    if p <= HARD and skipped > judged / 2:
        return "Mostly skipped, since a check before it failed."
    if p <= HARD:
        return "Few pass: is it taught in time and worded clearly?"
    if p >= EASY:
        return "Nearly all pass: it separates nobody."
    if r is None:
        return ""
    if r < WEAK:
        return "Passing it says little about the rest of the work."
    return "Separates well." if r >= GOOD else "Separates fairly."
