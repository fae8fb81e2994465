"""`course start`: what a student finds in the new folder, and that no work is overwritten."""

import re
from pathlib import Path

import pytest

from grader.course.begin import begin, to_begin
from grader.course.exercises import Exercise, all_exercises, find_exercise
from grader.errors import InputError
from sim.scenario_files import scenario_names

ALL = all_exercises()


@pytest.mark.parametrize("exercise", ALL, ids=lambda exercise: exercise.slug)
def test_all_that_a_student_needs_is_there(exercise: Exercise, tmp_path: Path) -> None:
    folder = begin(exercise, tmp_path)
    for name in exercise.files:
        assert (folder / name).read_bytes() == (exercise.folder / name).read_bytes()
    tests = (folder / f"test_{exercise.slug}.py").read_text("utf-8")
    file, scenario = re.findall(r'^FILE, SCENARIO = "(.+)", "(.+)"$', tests, re.MULTILINE)[0]
    assert file in exercise.files
    assert scenario in scenario_names()
    for page in ("README.md", "hints.md"):
        for link in re.findall(r"\]\((?!https?:)([^)#]+)", (folder / page).read_text("utf-8")):
            other = re.fullmatch(r"\.\./(\w+)/README\.md", link)  # there once it is begun
            assert find_exercise(other[1]) if other else (folder / link).is_file(), link


def test_work_is_not_overwritten_and_the_next_one_is_begun(tmp_path: Path) -> None:
    mine = begin(to_begin(tmp_path), tmp_path) / ALL[0].files[0]
    mine.write_text("mine")
    with pytest.raises(InputError, match="there already, and may hold work of yours"):
        begin(ALL[0], tmp_path)
    assert mine.read_text() == "mine"
    assert to_begin(tmp_path) == ALL[1]
    with pytest.raises(InputError, match="no_such"):
        begin(ALL[0], tmp_path / "no_such")
