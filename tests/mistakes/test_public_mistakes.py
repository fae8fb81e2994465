"""The list of public mistakes: every edit fits, in one place, and makes what its class says.

README.md says what the keys of a mistake mean.
"""

import tomllib
from pathlib import Path
from urllib.parse import urlsplit

import pytest

from grader.authoring.edits import edited
from grader.authoring.mutants import mutants
from grader.course.exercises import Exercise, all_exercises

HERE = Path(__file__).parent
KEYS = {"class", "mistake", "cause", "source", "address", "edit"}
MORE = {"base", "requires"}  # that few have
# The list was fixed before there were others
LISTED = [each for each in all_exercises() if (HERE / f"{each.slug}.toml").is_file()]
SYNTAX = "syntax"  # the class of mistakes that do not compile

Mistake = dict[str, str]


def mistakes(exercise: Exercise) -> dict[str, Mistake]:
    """Return an exercise's mistakes by name, in the order of the list."""
    found = tomllib.loads((HERE / f"{exercise.slug}.toml").read_text("utf-8"))
    return {name: {"base": found["base"], **table} for name, table in found["mistake"].items()}


def wrong(exercise: Exercise, mistake: Mistake) -> str:
    """Return the reference's file with the mistake in it."""
    lines = (exercise.solutions / mistake["base"]).read_text("utf-8").splitlines()
    return "".join(f"{line}\n" for line in edited(lines, mistake["edit"], mistake["base"]))


def compiles(text: str) -> bool:
    try:
        compile(text, "node.py", "exec", dont_inherit=True)
    except SyntaxError:
        return False
    return True


@pytest.mark.filterwarnings("ignore::SyntaxWarning")
@pytest.mark.parametrize("exercise", LISTED, ids=lambda one: one.slug)
def test_every_edit_fits_and_no_two_make_one_program(exercise: Exercise) -> None:
    found = mistakes(exercise)
    programs = {(exercise.solutions / file).read_text("utf-8") for file in exercise.files}
    for name, mistake in found.items():
        assert KEYS <= mistake.keys() <= KEYS | MORE, name
        text = wrong(exercise, mistake)
        assert text not in programs, name
        programs.add(text)
        assert compiles(text) == (mistake["class"] != SYNTAX), name
        assert urlsplit(mistake["address"]).scheme == "https", name
    assert found.keys().isdisjoint(mutant.name for mutant in mutants(exercise))


def test_the_list_is_as_long_as_when_it_was_fixed() -> None:
    lengths = [len(mistakes(exercise)) for exercise in LISTED]
    assert lengths == [17, 16, 16, 16, 17, 17, 16, 18, 18]
