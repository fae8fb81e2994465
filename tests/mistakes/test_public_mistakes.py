"""The list of public mistakes: every edit fits, in one place, and makes what its class says."""

from urllib.parse import urlsplit

import pytest
from public_mistakes import SYNTAX, mistakes, submission

from grader.authoring.mutants import mutants
from grader.course.exercises import Exercise, all_exercises


def compiles(text: str) -> bool:
    try:
        compile(text, "node.py", "exec", dont_inherit=True)
    except SyntaxError:
        return False
    return True


@pytest.mark.filterwarnings("ignore::SyntaxWarning")
@pytest.mark.parametrize("exercise", all_exercises(), ids=lambda one: one.slug)
def test_every_edit_fits_and_no_two_make_one_program(exercise: Exercise) -> None:
    found = mistakes(exercise)
    references = [(exercise.solutions / file).read_text("utf-8") for file in exercise.files]
    programs = {*references}
    for name, mistake in found.items():
        text = submission(exercise, mistake)[mistake.base]
        assert text not in programs, name
        programs.add(text)
        assert compiles(text) == (mistake.kind != SYNTAX), name
        assert urlsplit(mistake.address).scheme == "https", name
    assert found.keys().isdisjoint(mutant.name for mutant in mutants(exercise))


def test_the_list_is_as_long_as_when_it_was_fixed() -> None:
    lengths = [len(mistakes(exercise)) for exercise in all_exercises()]
    assert lengths == [17, 16, 16, 16, 17, 17, 16, 18, 18]
