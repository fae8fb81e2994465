"""The notebooks as a release hands them out: nbgrader's own, and nothing in them is an answer."""

import json
import re
from pathlib import Path

import pytest
from nbgrader_kit import MadeOnce, make_course

from grader.authoring.handouts import made_by, notebooks, without
from grader.authoring.leaks import leaks
from grader.course.exercises import EXERCISES, ROOT, all_exercises
from grader.notebook import build

pytestmark = pytest.mark.long

ALL = build.all_notebooks()
RUBRIC = re.compile(r"(?m)^\| \d \| (.{20,}?) *\|$")


@pytest.fixture(scope="module")
def course(made_once: MadeOnce) -> Path:
    """The whole course, released: the same as tests/notebooks/test_course.py's."""
    return made_once("whole-course", lambda folder: make_course(folder, ALL))


@pytest.fixture(scope="module")
def released(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A release's folder with the notebooks and the skeletons."""
    folder = tmp_path_factory.mktemp("release")
    made = notebooks(tmp_path_factory.mktemp("work"))
    skeletons = {
        f"exercises/{file.parent.name}/{file.name}": file.read_bytes()
        for file in EXERCISES.glob("*/*.py")
    }
    for path, data in (made | skeletons).items():
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        (folder / path).write_bytes(data)
    return folder


def cells(folder: Path, name: str) -> list[tuple[str, str]]:
    """Return types and texts of a notebook's cells, whatever nbgrader notes beside them."""
    found = json.loads((folder / f"{name}.ipynb").read_text("utf-8"))["cells"]
    return [(cell["cell_type"], "".join(cell["source"])) for cell in found]


def test_they_are_what_nbgrader_gives_students(released: Path, course: Path) -> None:
    given = released / "notebooks"
    assert sorted(path.name for path in given.iterdir()) == [f"{name}.ipynb" for name in ALL]
    for name in ALL:
        assert cells(given, name) == cells(course / "release" / name, name)


def test_no_cell_has_a_piece_of_a_solution_or_mutant(released: Path) -> None:
    assert [str(leak) for leak in leaks(released) if not leak.earlier] == []
    # what a later skeleton gives away of exercise 1, the notebook with it gives away too
    earlier = {leak.solution.split("/")[1] for leak in leaks(released)}
    assert earlier == {"obstacle_avoidance"}


def test_the_rubric_and_the_gradebook_stay_behind(released: Path) -> None:
    rubric = RUBRIC.findall((ROOT / "lessons" / "quiz.md").read_text("utf-8"))
    assert len(rubric) > 10
    texts = [text for name in ALL for _, text in cells(released / "notebooks", name)]
    assert not [row for row in rubric if any(row in text for text in texts)]
    assert not [path for path in released.rglob("*") if path.suffix in (".db",)]


def test_every_skeleton_is_in_one_notebook() -> None:
    made = [file for name in ALL for file in made_by(build.source_of(name).read_bytes())]
    assert sorted(made) == sorted(file for e in all_exercises() for file in e.files)


def test_a_notebook_with_an_exercise_that_is_left_out_stays_behind(released: Path) -> None:
    made = {path.name: path.read_bytes() for path in (released / "notebooks").iterdir()}
    assert set(without(made, {"trend_memory", "slow_model"})) == {
        "01_loop.ipynb", "02_trained_model.ipynb", "03_goal.ipynb", "06_formats.ipynb",
        "07_quiz.ipynb",
    }  # fmt: skip
    assert without(made, ()) == made
