"""What students get, and that no answer is among it."""

from __future__ import annotations

import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from grader.errors import GraderError, InputError
from grader.exercises import ROOT, all_exercises
from grader.release import contents, leaks, questions, release
from grader.skeletons import strip_solution


@pytest.fixture(scope="module")
def released(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("release") / "course"
    release(folder, archive=True)
    return folder


def files(folder: Path) -> set[str]:
    return {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}


def test_students_get_what_they_need(released: Path) -> None:
    there = files(released)
    for exercise in all_exercises():
        for name in ("README.md", "hints.md", "exercise.toml", *exercise.files):
            assert f"exercises/{exercise.slug}/{name}" in there
        assert any(path.startswith(f"grader/checks/{exercise.slug}/") for path in there)
    assert {"README.md", "LICENSE", "pyproject.toml", "constraints.txt", "lessons/quiz.md"} <= there
    assert "sim/scenarios/demo/demo_wall.toml" in there


def test_students_get_no_answers(released: Path) -> None:
    for path in files(released):
        parts = path.split("/")
        assert parts[0] not in ("solutions", "tests", "benchmarks", ".git", ".venv"), path
        assert not {"mutants", "variants", "batch", "results", "__pycache__"} & set(parts), path
        assert Path(path).name not in ("design.md", "mutants.md", "proof.py"), path


def test_no_piece_of_a_solution_is_handed_out(released: Path) -> None:
    wrong = [str(leak) for leak in leaks(released) if not leak.earlier]
    assert wrong == []
    # where a later skeleton builds on an earlier exercise, it says so and is known
    assert {leak.solution.split("/")[1] for leak in leaks(released)} <= {"obstacle_avoidance"}


def test_one_exercise_alone_gives_nothing_away(tmp_path: Path) -> None:
    assert release(tmp_path / "week", exercises=["obstacle_avoidance"]) == []
    assert [path.name for path in (tmp_path / "week" / "exercises").iterdir()] == [
        "obstacle_avoidance"
    ]
    assert not (tmp_path / "week" / "sim" / "scenarios" / "goal_seeking").exists()
    assert "goal_seeking" not in (tmp_path / "week" / "README.md").read_text("utf-8")


@pytest.mark.parametrize("where", ["grader/helper.py", "lessons/lesson.md", "sim/new.py"])
@pytest.mark.parametrize(
    "source",
    ["obstacle_avoidance_agent.py", "variants/beginner_loops.py", "mutants/whole_circle.py"],
)
def test_the_search_finds_what_is_put_in(tmp_path: Path, where: str, source: str) -> None:
    solution = (ROOT / "solutions" / "obstacle_avoidance" / source).read_text("utf-8")
    lines = [line for line in solution.splitlines() if "###" not in line]
    start = next(i for i, line in enumerate(lines) if ".ranges" in line)
    target = tmp_path / where
    target.parent.mkdir(parents=True)
    target.write_text("    text\n" + "\n\n".join(lines[start - 2 : start + 8]), "utf-8")
    found = leaks(tmp_path)
    assert found
    assert not any(leak.earlier for leak in found)
    assert all(leak.solution.startswith("solutions/") for leak in found)


def test_a_skeleton_is_no_leak_and_its_solution_is(tmp_path: Path) -> None:
    source = ROOT / "solutions" / "goal_seeking" / "goal_seeking_agent.py"
    target = tmp_path / "exercises" / "goal_seeking" / source.name
    target.parent.mkdir(parents=True)
    target.write_text(strip_solution(source.read_text("utf-8")), "utf-8")
    assert leaks(tmp_path) == []
    target.write_text(source.read_text("utf-8"), "utf-8")
    assert {leak.solution for leak in leaks(tmp_path)} == {
        "",
        "solutions/goal_seeking/goal_seeking_agent.py",
    }


def test_a_leak_stops_the_release(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    solution = (ROOT / "solutions/goal_seeking/goal_seeking_agent.py").read_bytes()
    spoilt = contents() | {"sim/notes.py": solution}
    monkeypatch.setattr("grader.release.contents", lambda *_: spoilt)
    with pytest.raises(GraderError, match=r"nothing was released: sim/notes\.py"):
        release(tmp_path / "out", archive=True)
    assert list(tmp_path.iterdir()) == []


def test_secrets_lying_about_are_left_where_they_are(tmp_path: Path) -> None:
    for name in ("pyproject.toml", "LICENSE"):
        (tmp_path / name).write_bytes((ROOT / name).read_bytes())
    for path in (
        "secret.txt", "exercises/a/secret.toml", "exercises/a/a_solution.py", "exercises/a/.env.py",
        "sim/scenarios/hidden/final.toml", "sim/scenarios/a/hidden_exam.toml", "grader/key.pem",
        "lessons/private.md", "docs/mutants.md", "exercises/a/build/a.py",
    ):  # fmt: skip
        (tmp_path / path).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / path).write_text("secret = 1", "utf-8")
    (tmp_path / "sim" / "link.py").symlink_to(tmp_path / "secret.txt")
    (tmp_path / "exercises/a/README.md").write_text("public", "utf-8")
    assert set(contents((), tmp_path)) == {
        "LICENSE", "README.md", "pyproject.toml", "exercises/a/README.md",
    }  # fmt: skip


def test_the_quiz_comes_without_its_rubric() -> None:
    quiz = questions((ROOT / "lessons" / "quiz.md").read_text("utf-8"))
    assert quiz.count("\n## ") == 5
    assert "Name the three stages" in quiz
    assert "|" not in quiz
    assert "Proven by" not in quiz


def test_what_is_there_is_not_overwritten(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("mine")
    with pytest.raises(InputError, match="new or empty"):
        release(tmp_path)
    (tmp_path / "out.zip").write_text("mine")
    with pytest.raises(InputError, match="already there"):
        release(tmp_path / "out", archive=True)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["notes.txt", "out.zip"]


def test_the_archive_is_the_folder_and_the_same_each_time(released: Path, tmp_path: Path) -> None:
    packed = released.with_name("course.zip")
    with zipfile.ZipFile(packed) as archive:
        names = {name.removeprefix("course/") for name in archive.namelist()}
    assert names == files(released)
    release(tmp_path / "course", archive=True)
    assert (tmp_path / "course.zip").read_bytes() == packed.read_bytes()


def test_the_package_grades_a_skeleton(released: Path) -> None:
    def course(*arguments: str) -> subprocess.CompletedProcess[str]:
        environment = os.environ | {"PYTHONPATH": str(released), "COLUMNS": "100"}
        return subprocess.run(
            [sys.executable, "-m", "grader.cli", *arguments],
            cwd=released, env=environment, capture_output=True, text=True, timeout=120, check=False,
        )  # fmt: skip

    done = course("grade", "obstacle_avoidance", "exercises/obstacle_avoidance")
    assert done.returncode == 1, done.stderr
    assert "Score  0 / 100" in done.stdout
    help_ = course("--help").stdout
    assert "grade" in help_
    assert "autograde" not in help_
    assert "release" not in help_


def course_release(*arguments: object) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "grader.cli", "release", *map(str, arguments)],
        capture_output=True, text=True, timeout=60, check=False,
    )  # fmt: skip


def test_the_command_releases_one_exercise(tmp_path: Path) -> None:
    done = course_release(tmp_path / "week", "--exercise", "3", "--student-package")
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.split() == [
        *f"Students' material: {tmp_path / 'week'}".split(),
        *f"The same, packed: {tmp_path / 'week.zip'}".split(),
    ]
    assert (tmp_path / "week" / "exercises" / "goal_seeking").is_dir()


def test_the_command_says_which_skeletons_give_something_away(tmp_path: Path) -> None:
    done = course_release(tmp_path / "all")
    assert done.returncode == 0
    assert "Note: exercises/trend_memory/trend_agent.py has lines of" in done.stderr


def test_the_command_refuses_in_one_line(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("mine")
    done = course_release(tmp_path)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
    assert "new or empty" in done.stderr
