"""`course release --student-package` as an instructor runs it: site, notebooks and all."""

import json
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest
from nbgrader_kit import MadeOnce, whole_course

from grader.authoring.leaks import leaks
from grader.authoring.pitfalls import PITFALLS
from grader.course.exercises import ROOT, all_exercises
from grader.notebook.build import all_notebooks

pytestmark = pytest.mark.long


def course_release(folder: Path, *options: str) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "grader.cli", "release", str(folder), *options],
        capture_output=True, text=True, timeout=600, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert all(line.startswith("Note: ") for line in done.stderr.splitlines())


@pytest.fixture(scope="module")
def released(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("handouts") / "course"
    course_release(folder, "--student-package")
    return folder


def files(folder: Path) -> set[str]:
    return {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}


def test_students_get_lesson_notebooks_skeletons_scenarios_and_grader(released: Path) -> None:
    there = files(released)
    for exercise in all_exercises():
        assert {f"exercises/{exercise.slug}/{file}" for file in exercise.files} <= there
        assert f"lesson/exercises/{exercise.slug}/README.html" in there
    for pitfall in PITFALLS:
        assert f"lesson/pitfalls/{pitfall.name}.html" in there
        replays = map(pitfall.replay_of, pitfall.nodes)
        assert {f"lesson/pitfalls/replays/{name}.html" for name in replays} <= there
    assert {f"notebooks/{name}.ipynb" for name in all_notebooks()} <= there
    assert {
        "lesson/index.html",
        "sim/scenarios/demo/demo_wall.toml",
        "grader/cli/grade.py",
    } <= there
    assert not any(path.startswith(("lessons/", "solutions/", "tests/")) for path in there)


def cells(file: Path) -> list[tuple[str, str]]:
    """Return types and texts of a notebook's cells, whatever nbgrader notes beside them."""
    found = json.loads(file.read_text("utf-8"))["cells"]
    return [(cell["cell_type"], "".join(cell["source"])) for cell in found]


def test_the_notebooks_are_those_that_nbgrader_gives_students(
    released: Path, made_once: MadeOnce
) -> None:
    given = {path.name: path for path in whole_course(made_once).glob("release/*/*.ipynb")}
    mine = {path.name: path for path in (released / "notebooks").iterdir()}
    assert mine.keys() == given.keys()
    assert all(cells(mine[name]) == cells(given[name]) for name in given)


def test_nothing_is_an_answer(released: Path) -> None:
    found = leaks(released)
    assert [str(leak) for leak in found if not leak.earlier] == []
    # what a later skeleton gives away of exercise 1, the notebook with it gives away too
    assert {leak.solution.split("/")[1] for leak in found} == {"obstacle_avoidance"}


def test_nothing_names_the_machine_that_made_it(released: Path) -> None:
    for path in released.rglob("*"):
        if path.is_file():
            assert str(ROOT).encode() not in path.read_bytes(), path
            assert str(released.parent).encode() not in path.read_bytes(), path


def test_the_same_course_gives_the_same_archive(released: Path, tmp_path: Path) -> None:
    course_release(tmp_path / "course", "--student-package")
    packed = released.with_name("course.zip")
    assert (tmp_path / "course.zip").read_bytes() == packed.read_bytes()
    with zipfile.ZipFile(packed) as archive:
        names = {name.removeprefix("course/") for name in archive.namelist()}
    assert names == files(released)


def test_a_week_of_two_exercises_has_their_notebooks_and_no_other_skeleton(tmp_path: Path) -> None:
    course_release(tmp_path / "week", "--exercise", "1", "--exercise", "3", "--no-answers")
    there = files(tmp_path / "week")
    notebooks = {path for path in there if path.startswith("notebooks/")}
    assert notebooks == {f"notebooks/{name}.ipynb" for name in ("01_loop", "03_goal", "quiz")}
    known = {file for exercise in all_exercises() for file in exercise.files}
    skeletons = known & {path.rpartition("/")[2] for path in there if "_downloads/" in path}
    assert skeletons == {"obstacle_avoidance_agent.py", "goal_seeking_agent.py"}
    questions = (tmp_path / "week" / "lesson" / "check_your_understanding.html").read_text("utf-8")
    assert ("own-answer" in questions, "model-answer" in questions) == (True, False)
