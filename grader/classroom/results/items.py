"""The scores of a class in an exercise, and how often each of its checks failed."""

import re
import statistics
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from grader.classroom.amendments.marks import Check, checks_of, points_of
from grader.classroom.row import StoredResult
from grader.lms.book import Task
from grader.lms.clean import one_line

BINS = 10

_NUMBER = re.compile(r"[-\N{MINUS SIGN}]?\d+(?:[.,]\d+)*")


@dataclass(frozen=True)
class Item:
    """One check, over a whole class."""

    id: str
    title: str
    kind: str  # "core" or "field"
    failed: int
    skipped: int
    often: str  # the most frequent failure message; "" if none occurs twice
    times: int  # how often it occurs

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


def failures(graded: Sequence[StoredResult]) -> list[Item]:
    """Return how often each check of an exercise failed, in the order of the checks."""
    checks = [{str(check.get("id")): check for check in checks_of(result)} for result in graded]
    ids = list(dict.fromkeys(id_ for each in checks for id_ in each))
    return [_item(id_, [each[id_] for each in checks if id_ in each]) for id_ in ids]


def _item(id_: str, found: list[Check]) -> Item:
    outcomes = Counter(str(check.get("outcome")) for check in found)
    often, times = _often([check for check in found if check.get("outcome") == "fail"])
    return Item(
        id=id_,
        title=one_line(found[0].get("title") or id_, 200),
        kind="field" if found[0].get("kind") == "field" else "core",
        failed=outcomes["fail"],
        skipped=outcomes["skip"],
        often=often,
        times=times,
    )


def _often(failed: list[Check]) -> tuple[str, int]:
    """Return the most frequent message and its count; messages may differ in their numbers."""
    messages = [one_line(check.get("message") or "", 220) for check in failed]
    forms = Counter(_NUMBER.sub("#", message) for message in messages if message)
    if not forms:
        return "", 0
    form, times = max(forms.items(), key=lambda pair: (pair[1], pair[0]))
    if times < 2:
        return "", 0
    return min(message for message in messages if _NUMBER.sub("#", message) == form), times
