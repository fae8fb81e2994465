"""Write docs/mutants.md: which mistake is caught by which check.

What stands there comes from `solutions/*/mutants.toml`; that it is true is what the proof proves.
`python -m grader.authoring.catalogue` writes the page, `--check` tells whether it is up to date.
"""

from __future__ import annotations

import sys
from collections import defaultdict

from grader.authoring.claims import Claim, claims
from grader.course.exercises import ROOT, Exercise, all_exercises
from grader.course.generated import write_or_check

PAGE = ROOT / "docs" / "mutants.md"
HEAD = """\
# Which check catches which mistake

Every check of the course is proven by wrong solutions, *mutants*: nodes with one realistic mistake
each, written as an edit of a right one in `solutions/<exercise>/mutants.toml`. `make prove` grades
them all; each has to fail exactly the checks named here. (Checks that are skipped because one that
they need failed are not listed.) `python -m grader.authoring.mutants <exercise> <mutant>` prints
the complete program of one.

This page is made from those files by `python -m grader.authoring.catalogue`.
"""


def catalogue() -> str:
    """Return the page."""
    sections = [_section(exercise) for exercise in all_exercises()]
    return "\n".join([HEAD, *sections])


def main(arguments: list[str]) -> int:
    """Write the page, or with `--check` compare it; 1 if it is out of step."""
    return write_or_check([(PAGE, catalogue())], "python -m grader.authoring.catalogue", arguments)


def _section(exercise: Exercise) -> str:
    mutants = [claim for claim in claims(exercise) if claim.kind == "mutant"]
    by_check: dict[str, list[Claim]] = defaultdict(list)
    for claim in mutants:
        for check in sorted(claim.fails):
            by_check[check].append(claim)
    lines = [
        f"## {exercise.number} · {exercise.title} ({len(mutants)} mutants)\n",
        "| Mutant | The mistake | Caught by |",
        "|---|---|---|",
        *(_row(claim) for claim in mutants),
        "",
        "| Check | Killed by |",
        "|---|---|",
        *(f"| `{check}` | {len(by_check[check])} |" for check in sorted(by_check)),
        "",
    ]
    return "\n".join(lines)


def _row(claim: Claim) -> str:
    caught = ", ".join(f"`{check}`" for check in sorted(claim.fails))
    mistake = claim.about.replace("|", "\\|")
    return f"| `{claim.stem}` | {mistake} | {caught} |"


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
