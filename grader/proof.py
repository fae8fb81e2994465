"""Prove the graders: right solutions get full marks, wrong ones fail exactly the checks they name.

Every mutant says in its docstring which checks it fails::

    fails: stop_zone, no_contact        (core checks; those skipped through `needs` are not listed)
    field: field_speckle                (field checks, when they are run)

Field checks are only judged when all of the core passed, so a mutant names either kind. A variant
that claims the badge says `field: all`. `python -m grader.proof [EXERCISE …]` prints
which mutant is killed by which check.
"""

from __future__ import annotations

import ast
import re
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from grader.exercises import Exercise, all_exercises, find_exercise
from grader.grading import Grading, grade_live
from grader.launch import Nursery
from grader.plugin import FAIL
from grader.submission import find_submission
from sim.messages import EPOCH_NS

SKELETON_POINTS = 10  # at most


@dataclass(frozen=True)
class Claim:
    """A solution, right or wrong, and what it says about itself."""

    exercise: Exercise
    kind: str  # reference, variant, mutant or skeleton
    path: Path
    fails: frozenset[str] = frozenset()  # checks, core and field
    field_ready: bool = False

    @property
    def name(self) -> str:
        """A short name for tables and tests."""
        return f"{self.exercise.slug}/{self.kind}/{self.path.stem}"


def claims(exercise: Exercise) -> Iterator[Claim]:
    """Return all solutions of an exercise with their claims."""
    file = exercise.files[0]
    yield Claim(exercise, "reference", exercise.solutions / file, field_ready=True)
    yield Claim(exercise, "skeleton", exercise.folder / file)
    for path in sorted((exercise.solutions / "variants").glob("*.py")):
        ready = "all" in _listed("field", _docstring(path))
        yield Claim(exercise, "variant", path, field_ready=ready)
    for path in sorted((exercise.solutions / "mutants").glob("*.py")):
        doc = _docstring(path)
        yield Claim(exercise, "mutant", path, _listed("fails", doc) | _listed("field", doc))


def grade_claim(claim: Claim, nursery: Nursery) -> Grading:
    """Grade a solution with the core and the field checks."""
    submission = find_submission(claim.path, claim.exercise.files[0], claim.exercise.files[1:])
    return grade_live(claim.exercise, submission, nursery, file=claim.path.name, field=True)


def objections(claim: Claim, grading: Grading) -> list[str]:
    """Return what the grading has against the claim; nothing if it holds."""
    failed = {check.id for check in grading.checks if check.outcome == FAIL}
    found = [
        f"{check.id} is {check.outcome}: {check.message}"
        for check in grading.checks
        if check.outcome in ("error", "inconclusive")
    ]
    if claim.kind == "mutant":
        found += [f"should fail {check}, and does not" for check in sorted(claim.fails - failed)]
        found += [
            f"fails {check}, which it does not name" for check in sorted(failed - claim.fails)
        ]
        if not claim.fails:
            found.append("names no check that it fails")
    elif claim.kind == "skeleton":
        if grading.score > SKELETON_POINTS:
            found.append(f"gets {grading.score} points, at most {SKELETON_POINTS} are allowed")
    else:
        if grading.score != grading.exercise.max_points:
            found.append(f"gets {grading.score} of {grading.exercise.max_points}: fails {failed}")
        if claim.field_ready and not grading.field_ready:
            found.append(f"claims to be field-ready and fails {sorted(failed)}")
    return found


def main(names: list[str]) -> int:
    """Print the table of the exercises named (all by default); 1 if anything is wrong."""
    exercises = [find_exercise(name) for name in names] or all_exercises()
    bad: list[str] = []
    with Nursery(EPOCH_NS) as nursery:
        for exercise in exercises:
            bad += _prove(exercise, nursery)
    print(f"\n{len(bad)} objections" + "".join(f"\n  {line}" for line in bad))
    return 1 if bad else 0


def _prove(exercise: Exercise, nursery: Nursery) -> list[str]:
    bad: list[str] = []
    used: set[str] = set()
    core: set[str] = set()
    killed = mutants = 0
    for claim in claims(exercise):
        grading = grade_claim(claim, nursery)
        against = objections(claim, grading)
        bad += [f"{claim.name}: {line}" for line in against]
        core |= {check.id for check in grading.checks}
        by = sorted(check.id for check in grading.checks if check.outcome == FAIL)
        if claim.kind == "mutant":
            mutants += 1
            killed += bool(by)
            used |= set(by)
        badge = {True: "field-ready", False: "", None: ""}[grading.field_ready]
        said = ", ".join(by) if claim.kind == "mutant" else badge
        mark = "!" if against else " "
        print(f"{mark} {claim.name:64} {grading.score:3}  {said}", flush=True)
    print(f"{exercise.slug}: {killed} of {mutants} mutants killed")
    bad += [f"{exercise.slug}: no mutant needs the check {check}" for check in sorted(core - used)]
    return bad


def _docstring(path: Path) -> str:
    return ast.get_docstring(ast.parse(path.read_bytes())) or ""


def _listed(key: str, doc: str) -> frozenset[str]:
    match = re.search(rf"^{key}:(.*)$", doc, re.MULTILINE)
    return frozenset(re.findall(r"\w+", match[1])) - {"none"} if match else frozenset()


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
