"""What a single mistake costs, and what its author is told: figures of the proof, and a file.

`python -m grader.authoring.proof --keep FILE` writes a line for each claim that it graded. Whether
a cause in words of its own is the right one, only a person can say, so the file has both.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from statistics import median

import msgspec

from grader.grading.causes.known import catalogue, told_as
from grader.grading.grading import Grading
from grader.grading.plugin import FAIL

TOLD = 0.7  # of an exercise's mutants, at least, are told what is wrong


class Row(msgspec.Struct, frozen=True):
    """A claim, and what its grading came to."""

    exercise: str
    kind: str  # reference, variant, mutant or skeleton
    name: str
    mistake: str
    points: int
    most: int  # that could be won on this machine
    fails: tuple[str, ...]  # ids of checks
    cause: str  # the line above the table; "" if there is none

    @classmethod
    def of(cls, kind: str, name: str, mistake: str, grading: Grading) -> Row:
        """Return the row of a graded claim."""
        return cls(
            grading.exercise.slug,
            kind,
            name,
            mistake,
            grading.score,
            grading.max_score,
            tuple(sorted(check.id for check in grading.checks if check.outcome == FAIL)),
            "" if grading.cause is None else grading.cause.text,
        )

    @property
    def lost(self) -> int:
        """Points that it costs."""
        return self.most - self.points

    @property
    def named(self) -> bool:
        """Whether the cause says the mistake in the catalogue's own words."""
        return told_as(self.mistake) in self.cause


def keep(path: Path, rows: Iterable[Row]) -> None:
    """Write rows as JSON, one a line."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(b"".join(msgspec.json.encode(row) + b"\n" for row in rows))


def print_costs(rows: Iterable[Row]) -> None:
    """Print what the mutants of each exercise lose, and how many are told their mistake.

    Those that only fail field checks lose nothing, and are not in the median.
    """
    print(f"\n  {'':24} points lost       their mistake is told")
    print(f"  {'exercise':24} median worst   by name  otherwise  not at all   the worst")
    for slug, theirs in _mutants(rows).items():
        costly = sorted((row for row in theirs if row.lost), key=lambda row: row.lost)
        named = sum(row.named for row in theirs)
        silent = sum(not row.cause for row in theirs)
        middle = f"{median(row.lost for row in costly):.0f}" if costly else "-"
        worst, name = (costly[-1].lost, costly[-1].name) if costly else (0, "")
        print(
            f"  {slug:24} {middle:>6} {worst:5} {named:9} "
            f"{len(theirs) - named - silent:10} {silent:11}   {name}"
        )


def silences(rows: Iterable[Row]) -> list[str]:
    """Return the exercises whose known mistakes no longer fit: their mutants are told nothing.

    A check that says other figures changes the fingerprints by which mistakes are known.
    """
    found = []
    for slug, theirs in _mutants(rows).items():
        told = sum(bool(row.cause) for row in theirs)
        if catalogue(slug) and told < TOLD * len(theirs):
            found.append(
                f"{slug}: {told} of {len(theirs)} mutants are told a cause, fewer than {TOLD:.0%}: "
                f"run `python -m grader.authoring.causes {slug}`"
            )
    return found


def _mutants(rows: Iterable[Row]) -> dict[str, list[Row]]:
    """Return the mutants that failed something, by exercise."""
    found: dict[str, list[Row]] = {}
    for row in rows:
        if row.kind == "mutant" and row.fails:
            found.setdefault(row.exercise, []).append(row)
    return found
