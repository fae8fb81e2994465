"""Print which mistake is caught by which check, as a page of Markdown.

What stands there comes from `solutions/*/mutants.toml`; that it is true is what the proof proves.
It gives answers away, so it is not kept: `python -m grader.authoring.catalogue > build/mutants.md`.
"""

from __future__ import annotations

from collections import defaultdict

from grader.authoring.mutants import Mutant, mutants
from grader.course.exercises import Exercise, all_exercises

HEAD = """\
# Which check catches which mistake

Every check of the course is proven by wrong solutions, *mutants*: nodes with one realistic mistake
each, written as an edit of a right one in `solutions/<exercise>/mutants.toml`. `make prove` grades
them all; each has to fail the checks named here, and others may fail with it.
`python -m grader.authoring.mutants <exercise> <mutant>` prints the complete program of one.
"""


def catalogue() -> str:
    """Return the page."""
    sections = [_section(exercise) for exercise in all_exercises()]
    return "\n".join([HEAD, *sections])


def _section(exercise: Exercise) -> str:
    found = sorted(mutants(exercise), key=lambda mutant: mutant.name)
    by_check: dict[str, list[Mutant]] = defaultdict(list)
    for mutant in found:
        for check in sorted(mutant.fails):
            by_check[check].append(mutant)
    lines = [
        f"## {exercise.number} · {exercise.title} ({len(found)} mutants)\n",
        "| Mutant | The mistake | Caught by |",
        "|---|---|---|",
        *(_row(mutant) for mutant in found),
        "",
        "| Check | Killed by |",
        "|---|---|",
        *(f"| `{check}` | {len(by_check[check])} |" for check in sorted(by_check)),
        "",
    ]
    return "\n".join(lines)


def _row(mutant: Mutant) -> str:
    caught = ", ".join(f"`{check}`" for check in sorted(mutant.fails))
    mistake = mutant.mistake.replace("|", "\\|")
    return f"| `{mutant.name}` | {mistake} | {caught} |"


if __name__ == "__main__":
    print(catalogue(), end="")
