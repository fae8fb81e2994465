"""Behind the sentences of a README stand the checks that hold a node to them."""

import re

import pytest

from grader.claims.mutants import FIELD, check_names
from grader.course.exercises import Exercise, all_exercises
from grader.notebook.build import PROMISE

README = """\
1. **Decide.** Stand below 0.5 m. <!-- checks: stop_zone,
   blind --> Drive on.

| Reading | What to do |
|---|---|
| `-inf` | distance 0 <!-- checks: minus_infinity --> |
"""


def promised(text: str) -> set[str]:
    return {name for names in PROMISE.findall(text) for name in re.findall(r"\w+", names)}


@pytest.mark.parametrize("exercise", all_exercises(), ids=lambda exercise: exercise.slug)
def test_every_check_of_the_core_is_promised(exercise: Exercise) -> None:
    known = check_names(exercise)
    core = {check for check in known if not check.startswith(FIELD)}
    readme = exercise.folder / "README.md"
    found = promised(readme.read_text("utf-8"))
    assert found - known == set(), f"{readme}: no such check"
    wanted = f"write <!-- checks: … --> behind the sentence of {readme} that asks for it"
    assert core - found == set(), wanted


@pytest.mark.parametrize("exercise", all_exercises(), ids=lambda exercise: exercise.slug)
def test_a_readme_is_short_and_links_words_that_the_glossary_has(exercise: Exercise) -> None:
    text = PROMISE.sub("", (exercise.folder / "README.md").read_text("utf-8"))
    linked = re.findall(r"\[([^\]]+)\]\(\.\./glossary\.md\)", text)
    glossary = (exercise.folder.parent / "glossary.md").read_text("utf-8").lower().splitlines()
    assert [word for word in linked if word.lower() not in glossary] == []
    assert len(linked) == len(set(linked)), "at first use"
    read = re.sub(r"<!--.*?-->|(?<=\])\([^)]*\)", "", text)
    words = [word for word in read.split() if re.search(r"\w", word)]
    assert len(words) <= (500 if exercise.number == 1 else 700)


def test_comments_are_read_and_taken_out() -> None:
    assert promised(README) == {"blind", "minus_infinity", "stop_zone"}
    text = PROMISE.sub("", README)
    assert "Stand below 0.5 m. Drive on.\n" in text
    assert "| `-inf` | distance 0 |\n" in text
