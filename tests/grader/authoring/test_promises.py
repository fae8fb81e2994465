"""Each sentence of a README on what a node does is checked, or says that it is not graded."""

from collections import Counter
from pathlib import Path

import pytest

from grader.authoring.mutants import check_names
from grader.authoring.promises import promises, sentences
from grader.course.exercises import Exercise, all_exercises

each = pytest.mark.parametrize("exercise", all_exercises(), ids=lambda exercise: exercise.slug)
FIELD = "field_"  # field checks ask the same of other robots


@each
def test_every_sentence_of_the_readme_is_in_the_list(exercise: Exercise) -> None:
    said, listed = sentences(exercise.folder / "README.md"), promises(exercise).sentences
    assert [sentence for sentence in said if sentence not in listed] == [], "not in promises.toml"
    assert [sentence for sentence in listed if sentence not in said] == [], "not in the README"
    assert [s for s, times in Counter(listed).items() if times > 1] == [], "listed twice"


@each
def test_promises_name_checks_and_every_check_has_a_promise(exercise: Exercise) -> None:
    known = check_names(exercise)
    named = {check for checks in promises(exercise).checked.values() for check in checks}
    assert named - known == set(), "no such checks"
    core = {check for check in known if not check.startswith(FIELD)}
    assert core - named == set(), "no sentence asks for these"


@each
def test_what_is_not_graded_says_so(exercise: Exercise) -> None:
    assert [s for s in promises(exercise).not_graded if "not graded" not in s] == []


def test_a_readme_falls_into_sentences_and_rows(tmp_path: Path) -> None:
    readme = tmp_path / "README.md"
    readme.write_text(
        "# Title\n\nNot this. Nor this.\n\n## Topics\n\n| Head | Type |\n|---|---|\n| `a` | b |\n"
        "\n## Tasks\n\n1. **Wire.** Make\n   a timer. Spin it.\n2. Stop.\n\n    course grade it\n\n"
        "```\nprint(1)\n```\n\n## How to run it\n\nNot this.\n"
    )
    assert sentences(readme) == ["| `a` | b |", "**Wire.** Make a timer.", "Spin it.", "Stop."]
