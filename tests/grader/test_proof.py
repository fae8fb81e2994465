"""Every solution, right or wrong, gets what it says it deserves."""

import pytest

from grader.exercises import all_exercises
from grader.launch import Nursery
from grader.proof import Claim, claims, grade_claim, objections

ALL = [claim for exercise in all_exercises() for claim in claims(exercise)]


@pytest.mark.parametrize("claim", ALL, ids=lambda claim: claim.name)
def test_claims_hold(claim: Claim, nursery: Nursery) -> None:
    assert objections(claim, grade_claim(claim, nursery)) == []


@pytest.mark.parametrize("exercise", all_exercises(), ids=lambda exercise: exercise.slug)
def test_there_are_solutions_of_every_kind(exercise: object) -> None:
    kinds = {claim.kind for claim in ALL if claim.exercise == exercise}
    assert kinds == {"reference", "skeleton", "variant", "mutant"}
