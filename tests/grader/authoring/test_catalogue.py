"""docs/mutants.md is in step with the mutants."""

from grader.catalogue import PAGE, catalogue
from grader.exercises import all_exercises
from grader.proof import claims


def test_the_page_is_up_to_date() -> None:
    assert PAGE.read_text("utf-8") == catalogue(), "run `python -m grader.catalogue`"


def test_every_mutant_says_what_its_mistake_is() -> None:
    for exercise in all_exercises():
        for claim in claims(exercise):
            if claim.kind == "mutant":
                assert len(claim.about) > 12, claim.name
                assert "fails:" not in claim.about, claim.name
