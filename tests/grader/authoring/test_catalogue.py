"""docs/mutants.md is in step with the mutants."""

from grader.authoring.catalogue import PAGE, catalogue
from grader.authoring.claims import claims
from grader.course.exercises import all_exercises


def test_the_page_is_up_to_date() -> None:
    assert PAGE.read_text("utf-8") == catalogue(), "run `python -m grader.authoring.catalogue`"


def test_every_mutant_says_what_its_mistake_is() -> None:
    for exercise in all_exercises():
        for claim in claims(exercise):
            if claim.kind == "mutant":
                assert len(claim.about) > 12, claim.name
                assert "fails:" not in claim.about, claim.name
