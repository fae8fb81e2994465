"""`course release --student-package` as an instructor runs it: site, notebooks and all."""

import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from grader.authoring.leaks import leaks
from grader.authoring.pitfalls import PITFALLS
from grader.course.exercises import ROOT, all_exercises

pytestmark = pytest.mark.long


def course_release(folder: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "grader.cli", "release", str(folder), "--student-package"],
        capture_output=True, text=True, timeout=600, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert all(line.startswith("Note: ") for line in done.stderr.splitlines())


@pytest.fixture(scope="module")
def released(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("handouts") / "course"
    course_release(folder)
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
        assert {f"lesson/pitfalls/replays/{node}.html" for node in pitfall.nodes} <= there
    sources = (ROOT / "notebooks" / "source").rglob("*.ipynb")
    assert {f"notebooks/{file.name}" for file in sources} <= there
    assert {
        "lesson/index.html",
        "sim/scenarios/demo/demo_wall.toml",
        "grader/cli/grade.py",
    } <= there
    assert not any(path.startswith(("lessons/", "solutions/", "tests/")) for path in there)


def test_nothing_is_an_answer(released: Path) -> None:
    assert [str(leak) for leak in leaks(released) if not leak.earlier] == []


def test_nothing_names_the_machine_that_made_it(released: Path) -> None:
    for path in released.rglob("*"):
        if path.is_file():
            assert str(ROOT).encode() not in path.read_bytes(), path
            assert str(released.parent).encode() not in path.read_bytes(), path


def test_the_same_course_gives_the_same_archive(released: Path, tmp_path: Path) -> None:
    course_release(tmp_path / "course")
    packed = released.with_name("course.zip")
    assert (tmp_path / "course.zip").read_bytes() == packed.read_bytes()
    with zipfile.ZipFile(packed) as archive:
        names = {name.removeprefix("course/") for name in archive.namelist()}
    assert names == files(released)


def test_a_week_of_two_exercises_has_their_notebooks_and_no_other_skeleton(tmp_path: Path) -> None:
    chosen = ["--exercise", "1", "--exercise", "3"]
    done = subprocess.run(
        [sys.executable, "-m", "grader.cli", "release", str(tmp_path / "week"), *chosen],
        capture_output=True, text=True, timeout=600, check=False,
    )  # fmt: skip

    said = [line for line in done.stderr.splitlines() if "no wheel is in dist" not in line]
    assert (done.returncode, said) == (0, [])
    there = files(tmp_path / "week")
    notebooks = {path for path in there if path.startswith("notebooks/")}
    assert notebooks == {f"notebooks/{name}.ipynb" for name in ("01_loop", "03_goal", "07_quiz")}
    known = {file for exercise in all_exercises() for file in exercise.files}
    skeletons = known & {path.rpartition("/")[2] for path in there if "_downloads/" in path}
    assert skeletons == {"obstacle_avoidance_agent.py", "goal_seeking_agent.py"}
