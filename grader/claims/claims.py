"""Solutions, right or wrong, with what they say of themselves; and how one is graded.

A reference and a variant are right; a variant that claims the badge says so in its docstring:
`field: all`. Of an exercise with several files, a variant is a folder with some of them, or one
file that says which it stands for (`file: detection_client.py`; the first by default). Those that
it lacks are the reference's. The wrong ones, mutants, are edits (see `grader.claims.mutants`).
"""

from __future__ import annotations

import ast
import contextlib
import re
import tempfile
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from grader.claims.mutants import FIELD, mutants, stands_for, submission_of
from grader.course.exercises import Exercise
from grader.course.installed import why_not
from grader.course.submission import Submission, find_submission
from grader.grading.grading import Grading, grade_submission
from grader.trial.kept import KeptRecordings
from rclpy_virtual_time import Launcher


@dataclass(frozen=True)
class Claim:
    """A solution, right or wrong, and what it says about itself."""

    exercise: Exercise
    kind: str  # reference, variant, mutant or skeleton
    stem: str  # its name: of a file or folder, or in the catalogue of mutants
    files: Mapping[str, str]  # the texts of all files of the exercise
    about: str = ""  # what is special about it, or its mistake
    fails: frozenset[str] = frozenset()  # checks, core and field
    field_ready: bool = False
    requires: frozenset[str] = frozenset()  # modules without which it can't be graded

    @property
    def lacks(self) -> str:
        """Say which of its modules are not installed here; empty if all are."""
        return why_not(sorted(self.requires))

    @property
    def name(self) -> str:
        """A short name for tables and tests."""
        return f"{self.exercise.slug}/{self.kind}/{self.stem}"


def claims(exercise: Exercise) -> Iterator[Claim]:
    """Return all solutions of an exercise with their claims.

    Raises InputError: the catalogue of mutants is broken.
    Raises GraderError: a variant stands for a file that the exercise does not have.
    """
    stem = Path(exercise.files[0]).stem
    reference = _texts(exercise, exercise.solutions)
    yield Claim(exercise, "reference", stem, reference, field_ready=True)
    yield Claim(exercise, "skeleton", stem, _texts(exercise, exercise.folder))
    for path in sorted((exercise.solutions / "variants").glob("*")):
        if path.suffix == ".py" or _texts(exercise, path):
            yield claim_of(exercise, "variant", path)
    for mutant in sorted(mutants(exercise), key=lambda mutant: mutant.name):
        yield Claim(
            exercise,
            "mutant",
            mutant.name,
            submission_of(exercise, mutant),
            mutant.mistake,
            mutant.fails,
            requires=mutant.requires,
        )


def claim_of(exercise: Exercise, kind: str, path: Path) -> Claim:
    """Return the claim of a file, or of a folder with files of the exercise."""
    own = _texts(exercise, path)
    if path.is_file():
        own = {stands_for(exercise, path): path.read_text("utf-8")}
    doc = "\n".join(ast.get_docstring(ast.parse(text)) or "" for text in own.values())
    ready = re.search(r"^field:.*\ball\b", doc, re.MULTILINE) is not None
    about = " ".join(doc.split("\n\n")[0].split())
    files = {**_texts(exercise, exercise.solutions), **own}
    return Claim(exercise, kind, path.stem, files, about, field_ready=ready)


def grade_claim(
    claim: Claim,
    launcher: Launcher,
    *,
    field: bool = True,
    only: Iterable[str] = (),
    kept: KeptRecordings | None = None,
) -> Grading:
    """Grade a solution with the core and the field checks, or only some; see `grade_submission`."""
    with complete(claim) as submission:
        return grade_submission(
            claim.exercise,
            submission,
            launcher,
            file=f"{claim.stem}.py",
            field=field,
            only=only,
            kept=kept,
        )


def cover(
    exercise: Exercise, *, field: bool = False, without: Collection[str] = ()
) -> list[tuple[Claim, frozenset[str]]]:
    """Return few mutants that together fail every check that any fails, and what each is for.

    Greedy: the next one is always that which fails most checks that none before it did; it is for
    those, so that no check is judged twice.

    Parameters
    ----------
    field
        Of the field checks, in place of the core's.
    without
        Names of mutants that are not taken, as they take long.
    """
    provable = [each for each in claims(exercise) if each.kind == "mutant" and not each.lacks]
    provable = [each for each in provable if each.stem not in without]
    named = {
        each.stem: frozenset(check for check in each.fails if check.startswith(FIELD) == field)
        for each in provable
    }
    left = set().union(*named.values())
    chosen = []
    while left:
        best = max(provable, key=lambda each: (len(named[each.stem] & left), each.stem))
        chosen.append((best, named[best.stem] & left))
        left -= named[best.stem]
    return chosen


@contextlib.contextmanager
def complete(claim: Claim) -> Iterator[Submission]:
    """Yield the claim's submission, in a folder of its own."""
    first, *others = claim.exercise.files
    with tempfile.TemporaryDirectory(prefix="course-claim-") as name:
        folder = Path(name)
        for file, text in claim.files.items():
            (folder / file).write_text(text, "utf-8")
        yield find_submission(folder, first, others)


def _texts(exercise: Exercise, folder: Path) -> dict[str, str]:
    there = [file for file in exercise.files if (folder / file).is_file()]
    return {file: (folder / file).read_text("utf-8") for file in there}
