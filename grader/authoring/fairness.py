"""Is the exam the same for everybody? Grade right solutions in the worlds of many students.

Each student has different worlds, so a right solution must get full marks in all of them.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from grader.authoring.claims import Claim, claims, complete
from grader.authoring.proof import objections
from grader.course.exercises import find_exercise
from grader.course.students import student_key
from grader.grading.grading import grade_submission
from grader.grading.plugin import FAIL
from grader.link.hosts import ForkServer
from sim.messages import EPOCH_NS

SECRET = b"not a secret: for measuring only"


def right_solutions(slug: str, *, variants: bool = True) -> list[Claim]:
    """Return the reference of an exercise, and its variants."""
    kinds = ("reference", "variant") if variants else ("reference",)
    return [claim for claim in claims(find_exercise(slug)) if claim.kind in kinds]


def examine(claim: Claim, students: Iterable[int], *, field: int = 0) -> Iterator[list[str]]:
    """Grade a right solution in the worlds of each student; yield what is against it there.

    Parameters
    ----------
    field
        For how many students, from the first on, the field checks are judged too (if the solution
        claims the badge).
    """
    exercise = claim.exercise
    with (
        ForkServer(EPOCH_NS, libraries=exercise.libraries) as forkserver,
        complete(claim) as submission,
    ):
        for student in students:
            grading = grade_submission(
                exercise,
                submission,
                forkserver,
                file=exercise.files[0],
                field=claim.field_ready and student < field,
                seed=student_key(SECRET, f"student {student}", exercise.slug),
            )
            said = [
                f"student {student}: {check.id} in {check.scenario}: {check.message} (expected "
                f"{check.expected}, actual {check.actual}, at {check.time})"
                for check in grading.checks
                if check.outcome == FAIL
            ]
            yield [*objections(claim, grading), *said]
