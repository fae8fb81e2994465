"""The engine's own wheel in an environment of its own, and beside the course's."""

import os
import shutil
import subprocess
import sys
import venv
import zipfile
from collections.abc import Sequence
from pathlib import Path

import pytest

from rclpy_virtual_time.tests.testing.test_engine_readme import package_in

ROOT = Path(__file__).resolve().parents[2]
ACTIONS = "ros-jazzy-test-msgs==2.0.3"
pytestmark = pytest.mark.long  # they install ROS


def wheel(project: Path, folder: Path) -> Path:
    pip = [sys.executable, "-m", "pip", "--disable-pip-version-check", "wheel", "--quiet"]
    options = ["--no-deps", "--no-build-isolation", "--wheel-dir", str(folder), str(project)]
    subprocess.run([*pip, *options], check=True, timeout=300)
    (made,) = folder.glob("*.whl")
    return made


@pytest.fixture(scope="module")
def engine(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("engine")
    for name in ("rclpy_virtual_time", "rclpy_portable"):  # a build writes beside its sources
        shutil.copytree(ROOT / name, folder / name)
    return wheel(folder / "rclpy_virtual_time", folder)


@pytest.fixture(scope="module")
def course(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return wheel(ROOT, tmp_path_factory.mktemp("course"))


def said_with(wheels: Sequence[Path | str], folder: Path, *options: str) -> str:
    """Install these in a new environment; return what pytest says of the README's test there."""
    venv.create(folder / "env", with_pip=True)
    python = folder / "env" / "bin" / "python"
    command = [python, "-m", "pip", "install", "--quiet", "--constraint", ROOT / "constraints.txt"]
    subprocess.run([*command, *wheels], check=True, timeout=600)
    package_in(folder / "run")
    done = subprocess.run(
        [python, "-m", "pytest", "-W", "error", "--trace-config", *options],
        cwd=folder / "run", env={"PATH": os.environ["PATH"], "HOME": str(folder)}, text=True,
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=300, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout
    return done.stdout


def test_it_holds_the_engine_and_the_portable_runtime(engine: Path) -> None:
    names = zipfile.ZipFile(engine).namelist()
    tops = {name.partition("/")[0] for name in names}
    packages = {top for top in tops if not top.endswith(".dist-info")}
    assert packages == {"rclpy_virtual_time", "rclpy_portable"}
    for wanted in (
        "rclpy_virtual_time/host/real_time/live.xml", "rclpy_virtual_time/conform/reviewed.toml",
        "rclpy_virtual_time/host/stand_ins/tf2_ros/buffer.py", "rclpy_portable/_ros/NOTICE",
    ):  # fmt: skip
        assert wanted in names
    assert not [name for name in names if "/tests/" in name]


def test_alone(engine: Path, tmp_path: Path) -> None:
    assert "5 passed" in said_with([engine, ACTIONS], tmp_path)


def test_alone_on_the_portable_runtime(engine: Path, tmp_path: Path) -> None:
    assert "4 passed, 1 skipped" in said_with([engine], tmp_path, "--virtual-time-portable")


def test_beside_the_course(engine: Path, course: Path, tmp_path: Path) -> None:
    said = said_with([engine, course], tmp_path)
    assert "4 passed, 1 skipped" in said
    registered = [line for line in said.splitlines() if "registered: <module" in line]
    assert sum("testing.plugin" in line or "engine_plugin" in line for line in registered) == 1
    assert sum("rclpy_agents_course.pytest_plugin" in line for line in registered) == 1
