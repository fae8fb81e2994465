"""Right solutions get full marks in the worlds of a few students; `make students` asks 200."""

import os

import pytest

from grader.authoring.claims import Claim
from grader.authoring.fairness import examine, right_solutions
from grader.course.exercises import all_exercises

EXERCISES = [exercise.slug for exercise in all_exercises()]
QUICK = ("trend_memory",)  # in `make test`
STUDENTS = int(os.environ.get("COURSE_STUDENTS", "0"))  # make students: 200 for each reference
RIGHT = [claim for slug in EXERCISES for claim in right_solutions(slug)] if STUDENTS else []


@pytest.mark.parametrize(
    "slug",
    [pytest.param(slug, marks=() if slug in QUICK else pytest.mark.long) for slug in EXERCISES],
)
def test_a_student_gets_full_marks_in_worlds_of_their_own(slug: str) -> None:
    (reference,) = right_solutions(slug, variants=False)
    student = EXERCISES.index(slug)  # another one in each exercise
    assert list(examine(reference, [student])) == [[]]


@pytest.mark.long
@pytest.mark.parametrize("claim", RIGHT, ids=[claim.name for claim in RIGHT])
def test_right_solutions_get_full_marks_in_everybodys_worlds(claim: Claim) -> None:
    """Variants, and the field checks, meet a tenth of the students."""
    few = max(1, STUDENTS // 10)
    students = range(STUDENTS if claim.kind == "reference" else few)
    assert [line for said in examine(claim, students, field=few) for line in said] == []
