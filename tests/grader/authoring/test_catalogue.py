"""The list of all mistakes has each mutant, with its mistake."""

from grader.authoring.catalogue import catalogue
from grader.authoring.mutants import mutants
from grader.course.exercises import all_exercises


def test_every_mutant_is_on_the_page_with_its_mistake() -> None:
    rows = {line.split("`")[1] for line in catalogue().splitlines() if line.startswith("| `")}
    for exercise in all_exercises():
        for mutant in mutants(exercise):
            assert mutant.name in rows
            assert len(mutant.mistake) > 12, mutant.name
            assert "fails:" not in mutant.mistake, mutant.name
