"""Is the exam the same for everybody? Right solutions get full marks in each student's worlds.

`make students` asks 200 students.
"""

import os
from collections.abc import Iterable

import pytest

from grader.authoring.proof import objections
from grader.claims.claims import Claim, claims, complete
from grader.course.exercises import all_exercises
from grader.course.students import student_key
from grader.grading.grading import grade_submission
from grader.launchers import ForkServerPool

SECRET = b"not a secret: for measuring only"
QUICK = ("trend_memory",)  # in `make test`
STUDENTS = int(os.environ.get("COURSE_STUDENTS", "0"))  # make students: 200 for each reference
EVERY = [claim for exercise in all_exercises() for claim in claims(exercise)]
REFERENCES = [claim for claim in EVERY if claim.kind == "reference"]
RIGHT = [claim for claim in EVERY if STUDENTS and claim.kind in ("reference", "variant")]


def assert_full_marks(
    claim: Claim, students: Iterable[int], forkservers: ForkServerPool, *, field: int = 0
) -> None:
    """Grade a right solution in the worlds of each student; with field checks for the first."""
    exercise = claim.exercise
    against = []
    with complete(claim) as submission:
        for student in students:
            grading = grade_submission(
                exercise, submission, forkservers.of(exercise.libraries), file=exercise.files[0],
                field=claim.field_ready and student < field,
                seed=student_key(SECRET, f"student {student}", exercise.slug),
            )  # fmt: skip
            if said := objections(claim, grading):
                failed = [check for check in grading.checks if check.outcome == "fail"]
                against.append((student, said, failed))
    assert against == []


@pytest.mark.parametrize(
    "claim",
    [
        pytest.param(
            claim,
            id=claim.exercise.slug,
            marks=() if claim.exercise.slug in QUICK else pytest.mark.long,
        )
        for claim in REFERENCES
    ],
)
def test_a_student_gets_full_marks_in_worlds_of_their_own(
    claim: Claim, forkservers: ForkServerPool
) -> None:
    assert_full_marks(claim, [REFERENCES.index(claim)], forkservers)  # another one in each exercise


@pytest.mark.long
@pytest.mark.parametrize("claim", RIGHT, ids=[claim.name for claim in RIGHT])
def test_right_solutions_get_full_marks_in_everybodys_worlds(
    claim: Claim, forkservers: ForkServerPool
) -> None:
    """Variants, and the field checks, meet a tenth of the students."""
    few = max(1, STUDENTS // 10)
    students = range(STUDENTS if claim.kind == "reference" else few)
    assert_full_marks(claim, students, forkservers, field=few)
