"""What a single mistake costs: figures of the proof, and a file with a line for each claim.

`python -m grader.authoring.proof --keep FILE` writes it. Whether a cause is the right one, only a
person can say, so the file has both the mistake and the cause.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from statistics import median

import msgspec

from grader.grading.grading import Grading
from grader.grading.plugin import FAIL


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


def keep(path: Path, rows: Iterable[Row]) -> None:
    """Write rows as JSON, one a line."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(b"".join(msgspec.json.encode(row) + b"\n" for row in rows))


def print_costs(rows: Iterable[Row]) -> None:
    """Print what the mutants of each exercise lose.

    Those that only fail field checks lose nothing, and are not in the median.
    """
    print(f"\n  {'':24} points lost by a mistake")
    print(f"  {'exercise':24} median worst   the worst")
    for slug, theirs in _mutants(rows).items():
        costly = sorted((row for row in theirs if row.lost), key=lambda row: row.lost)
        middle = f"{median(row.lost for row in costly):.0f}" if costly else "-"
        worst, name = (costly[-1].lost, costly[-1].name) if costly else (0, "")
        print(f"  {slug:24} {middle:>6} {worst:5}   {name}")


def _mutants(rows: Iterable[Row]) -> dict[str, list[Row]]:
    """Return the mutants that failed something, by exercise."""
    found: dict[str, list[Row]] = {}
    for row in rows:
        if row.kind == "mutant" and row.fails:
            found.setdefault(row.exercise, []).append(row)
    return found
