"""What students get, and that no answer is among it."""

import json
import os
import re
import runpy
import shutil
import subprocess
import tomllib
from collections.abc import Collection
from pathlib import Path

import pytest

from grader.authoring import handouts
from grader.authoring.leaks import leaks
from grader.authoring.release import INSTRUCTORS, _walk, contents, drafts, questions, release
from grader.course.exercises import ROOT, all_exercises
from grader.errors import GraderError, InputError
from sim.scenario_files import EXTENDS, scenario_names

# What is made for a release is tested with the whole of it: tests/notebooks/test_handouts.py.


NOTHING = json.dumps({"cells": []}).encode()  # a notebook


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
        assert any(path.startswith(f"grader/exercises/{exercise.slug}/") for path in there)
    assert {"README.md", "LICENSE", "pyproject.toml", "constraints.txt", "lessons/quiz.md"} <= there
    assert "sim/scenarios/demo/demo_wall.toml" in there
    assert "grader/models/practice.npz" in there  # what exercise 2's expert said
    assert "grader/models/expert.py" not in there


def test_the_first_command_makes_an_environment_with_the_course_in_it(
    released: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    ran, codes = [], [0, 0, 0, 1]

    def run(command: list[str | Path]) -> subprocess.CompletedProcess[bytes]:
        ran.append(" ".join(map(str, command)))
        return subprocess.CompletedProcess(command, codes.pop(0))

    monkeypatch.setattr(subprocess, "run", run)
    monkeypatch.chdir(released)
    runpy.run_path("course_setup.py", run_name="__main__")
    assert ran[0].endswith(f"-m venv {released / '.venv'}")
    assert re.search(r"-m pip .* install .*--constraint \S+ --editable \S+\[ros\]$", ran[1])
    assert capsys.readouterr().out.endswith("Next: .venv/bin/course start\n")
    with pytest.raises(SystemExit, match="the lines above say why"):
        runpy.run_path("course_setup.py", run_name="__main__")


def test_students_get_the_fixtures_of_pytest(released: Path) -> None:
    settings = tomllib.loads((released / "pyproject.toml").read_text("utf-8"))
    for module in settings["project"]["entry-points"]["pytest11"].values():
        assert (released / module.replace(".", "/")).with_suffix(".py").is_file()
    ours = {path.relative_to(ROOT).as_posix() for path in ROOT.glob("grader/**/testing/*.py")}
    ours |= {p.relative_to(ROOT).as_posix() for p in ROOT.glob("rclpy_*/**/testing/*.py")}
    ours = {path for path in ours if "/tests/" not in path}
    assert len(ours) > 8
    assert ours <= files(released)


@pytest.mark.parametrize("exercises", [(), ("goal_seeking",)])
def test_links_of_students_documents_stay_inside(exercises: tuple[str, ...]) -> None:
    given = contents(exercises)
    names = ("students", "testing-your-node", "search", "live-robot", "portable")
    pages = {f"docs/{name}.md" for name in names}
    assert {path for path in given if path.startswith("docs/") and path.endswith(".md")} == pages
    for page in ("README.md", *sorted(pages)):
        text = given[page].decode("utf-8")
        for link in re.findall(r'\]\((?!https?:)([^)#]+)|(?:src|srcset)="([^"]+)"', text):
            target = os.path.normpath(Path(page).parent / "".join(link))
            assert target in given, f"{page}: {target}"


def test_students_get_the_ros_packages(tmp_path: Path) -> None:
    given = {
        "LICENSE", "pyproject.toml", "README.md",
        "exercises/package.xml", "exercises/setup.py", "exercises/setup.cfg",
        "exercises/resource/course_exercises", "exercises/launch/exercise.launch.py",
        "exercises/config/slow_model.yaml", "exercises/rviz/course.rviz", "sim/package.xml",
        "sim/resource/course_sim",
    }  # fmt: skip
    for name in ("pyproject.toml", "LICENSE"):
        (tmp_path / name).write_bytes((ROOT / name).read_bytes())
    for path in given | {"exercises/notes", "sim/worlds/draft", "exercises/secret.yaml"}:
        if not (tmp_path / path).exists():
            (tmp_path / path).parent.mkdir(parents=True, exist_ok=True)
            (tmp_path / path).write_text("", "utf-8")
    given.add("course_setup.py")  # made: what builds a released package
    assert set(contents((), tmp_path)) == given
    one = set(contents(["obstacle_avoidance"], tmp_path))
    assert given - one == {"exercises/config/slow_model.yaml"}


# --- what is made ----------------------------------------------------------------------------


def test_what_is_made_goes_out_in_place_of_the_plain_pages(tmp_path: Path) -> None:
    asked = []

    def make(left_out: Collection[str]) -> dict[str, bytes]:
        asked.append(set(left_out))
        return {"lesson/index.html": b"<p>The lesson</p>", "notebooks/01_loop.ipynb": NOTHING}

    release(tmp_path / "week", exercises=["obstacle_avoidance"], make=make)
    there = files(tmp_path / "week")
    assert {"lesson/index.html", "notebooks/01_loop.ipynb"} <= there
    assert not any(path.startswith("lessons/") for path in there)
    assert asked == [{e.slug for e in all_exercises()} - {"obstacle_avoidance"}]
    readme = (tmp_path / "week" / "README.md").read_text("utf-8")
    assert "`lesson/index.html`" in readme
    assert "jupyter lab notebooks" in readme
    assert "course grade 1 obstacle_avoidance\n" in readme
    assert len(readme.splitlines()) <= 60
    order = [readme.index(f"**{name}") for name in ("macOS", "Windows", "Linux", "A cloud")]
    assert order == sorted(order)


def test_without_sphinx_it_says_what_to_do(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(handouts, "NEEDED", {"json": "base", "sphynx": "site", "nbgreder": "class"})
    with pytest.raises(InputError) as refused:
        handouts.require_tools()
    said = str(refused.value)
    assert "sphynx, nbgreder are not installed" in said
    assert "pip install --editable '.[site,class]'" in said
    assert "--plain" in said


# --- what must not be there ------------------------------------------------------------------


def test_what_is_for_instructors_is_there_and_stays_there(released: Path) -> None:
    assert [each for each in INSTRUCTORS if not (ROOT / each).exists()] == []
    assert [each for each in INSTRUCTORS if (released / each).exists()] == []


def test_students_get_no_answers(released: Path) -> None:
    assert [str(leak) for leak in leaks(released) if not leak.earlier] == []
    # where a later skeleton builds on an earlier exercise, it says so and is known
    assert {leak.solution.split("/")[1] for leak in leaks(released)} <= {"obstacle_avoidance"}
    for path in files(released):
        parts = path.split("/")
        assert parts[0] not in ("solutions", "tests", "benchmarks", ".git", ".venv"), path
        assert not {"mutants", "variants", "batch", "results", "__pycache__"} & set(parts), path
        assert Path(path).name not in ("design.md", "mutants.md", "mutants.py", "proof.py"), path


@pytest.mark.long
def test_one_exercise_alone_gives_nothing_away(tmp_path: Path) -> None:
    assert release(tmp_path / "week", exercises=["obstacle_avoidance"]) == []
    given = (tmp_path / "week" / "exercises").glob("*/exercise.toml")
    assert [path.parent.name for path in given] == ["obstacle_avoidance"]
    assert not (tmp_path / "week" / "grader" / "exercises" / "goal_seeking").exists()
    assert "goal_seeking" not in (tmp_path / "week" / "README.md").read_text("utf-8")


def test_a_leak_stops_the_release(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    solution = (ROOT / "solutions/goal_seeking/goal_seeking_agent.py").read_bytes()
    spoilt = contents() | {"sim/notes.py": solution}  # as if somebody had put it there
    monkeypatch.setattr("grader.authoring.release.contents", lambda *_: spoilt)
    with pytest.raises(GraderError, match=r"nothing was released: sim/notes\.py"):
        release(tmp_path / "out", archive=True)
    assert list(tmp_path.iterdir()) == []


def test_secrets_lying_about_are_left_where_they_are(tmp_path: Path) -> None:
    for name in ("pyproject.toml", "LICENSE"):
        (tmp_path / name).write_bytes((ROOT / name).read_bytes())
    for path in (
        "secret.txt", "exercises/a/secret.toml", "exercises/a/a_solution.py", "exercises/a/.env.py",
        "sim/scenarios/hidden/final.toml", "grader/exercises/a/scenarios/hidden.toml",
        "sim/scenarios/a/hidden_exam.toml", "grader/key.pem",
        "lessons/private.md", "docs/mutants.md", "exercises/a/build/a.py", "notebooks/secret.txt",
        "notebooks/gradebook.db", "notebooks/source/01_loop/01_loop.ipynb",
        "notebooks/submitted/ada/01_loop/01_loop.ipynb",
    ):  # fmt: skip
        (tmp_path / path).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / path).write_text("secret = 1", "utf-8")
    (tmp_path / "sim" / "link.py").symlink_to(tmp_path / "secret.txt")
    (tmp_path / "exercises/a/README.md").write_text("public", "utf-8")
    assert set(contents((), tmp_path)) == {
        "LICENSE", "README.md", "course_setup.py", "pyproject.toml", "exercises/a/README.md",
    }  # fmt: skip


def test_a_scenario_goes_out_with_the_one_that_it_extends() -> None:
    places = scenario_names()
    for path in places.values():
        base = tomllib.loads(path.read_text("utf-8")).get(EXTENDS)
        if base is not None:
            assert places[base].parent in (path.parent, ROOT / "sim" / "scenarios" / "demo"), path


def test_the_quiz_comes_without_its_rubric() -> None:
    quiz = questions((ROOT / "lessons" / "quiz.md").read_text("utf-8"))
    assert quiz.count("\n## ") == 5
    assert "Name the three stages" in quiz
    assert "|" not in quiz
    assert "Proven by" not in quiz


def test_what_is_there_is_not_overwritten(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("mine")
    with pytest.raises(InputError, match="new or empty"):
        release(tmp_path, make=lambda _: pytest.fail("made in vain"))
    (tmp_path / "out.zip").write_text("mine")
    with pytest.raises(InputError, match="already exists"):
        release(tmp_path / "out", archive=True)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["notes.txt", "out.zip"]


def test_what_was_made_in_the_checkout_stays_there(tmp_path: Path) -> None:
    made = ("build/a.py", "dist/a.py", "_ros/rclpy/a.py", "a.egg-info/a.py", "__pycache__/a.pyc")
    for path in (*made, "room/a.py", ".a.py"):
        (tmp_path / path).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / path).touch()
    assert [*_walk(tmp_path)] == [tmp_path / "room/a.py"]


def test_what_nobody_has_added_to_git_stays_with_the_instructor(tmp_path: Path) -> None:
    for name in ("sim/scenarios/exam.toml", "grader/known.py", "sim/scenarios/known.toml"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text("")
    shutil.copy(ROOT / "pyproject.toml", tmp_path)
    for command in (["init", "--quiet"], ["add", "grader", "sim/scenarios/known.toml"]):
        subprocess.run(["git", "-C", tmp_path, *command], check=True)
    files = contents(root=tmp_path)
    assert {"grader/known.py", "sim/scenarios/known.toml"} <= set(files)
    assert "sim/scenarios/exam.toml" not in files
    assert drafts(tmp_path) == ["sim/scenarios/exam.toml"]
