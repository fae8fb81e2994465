"""Both ROS packages, built with setuptools as colcon does it, and what they install really runs.

`test_colcon.py` builds them with colcon itself.
"""

import ast
import re
import subprocess
import sys
import tomllib
import xml.etree.ElementTree as ET
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from ros_workspace import (
    COMMANDS,
    SCANS,
    ask,
    copy_sources,
    environment,
    on_a_network_of_its_own,
    running,
)

from grader.course.exercises import ROOT, all_exercises

FOLDERS = {"course_sim": "sim", "course_exercises": "exercises"}
FILES = [file for exercise in all_exercises() for file in exercise.files]
PROGRAMS = {Path(file).stem for file in FILES if not file.endswith("launch.py")}
ROS = re.compile(r"^(rclpy|launch|launch_ros|ament_index_python)$|_(msgs|srvs|interfaces)$")
WHERE = """
import importlib.metadata, importlib.util
for point in importlib.metadata.entry_points(group="console_scripts"):
    if point.value.startswith(("course_exercises.", "sim.")):
        print(point.name, point.attr, importlib.util.find_spec(point.module).origin)
"""


def install(source: Path, name: str, prefix: Path) -> None:
    """Install a package with the commands that colcon gives to setuptools."""
    made = prefix.parent / "build" / name
    (made / "build").mkdir(parents=True)
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "setup.py", "egg_info", "--egg-base", str(made),
         "build", "--build-base", str(made / "build"),
         "install", "--record", str(made / "install.log"), "--prefix", str(prefix),
         "--install-scripts", f"$base/lib/{name}", "--single-version-externally-managed"],
        cwd=source / FOLDERS[name], capture_output=True, text=True, check=False, timeout=120,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr


@pytest.fixture(scope="module")
def prefixes(made_once: Callable[[str, Callable[[Path], object]], Path]) -> list[Path]:
    """The install spaces of both packages, made once for all of pytest's workers."""
    pytest.importorskip("setuptools", reason="setuptools is not installed")

    def make(folder: Path) -> None:
        copy_sources(folder / "src")
        for name in FOLDERS:
            install(folder / "src", name, folder / "install" / name)

    return [made_once("ros_packages", make) / "install" / name for name in FOLDERS]


def test_names_and_versions_are_the_same_everywhere(prefixes: list[Path]) -> None:
    version = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]["version"]
    for prefix, name in zip(prefixes, FOLDERS, strict=True):
        manifest = ET.parse(ROOT / FOLDERS[name] / "package.xml").getroot()
        assert manifest.get("format") == "3"
        assert (manifest.findtext("name"), manifest.findtext("version")) == (name, version)
        assert manifest.findtext("export/build_type") == "ament_python"
        assert manifest.findtext("license") == "Apache-2.0"
        assert next(prefix.glob(f"lib/python*/site-packages/{name}-{version}*"), None)
        assert (prefix / "share" / "ament_index" / "resource_index" / "packages" / name).is_file()
        assert (prefix / "share" / name / "package.xml").is_file()


def test_everything_is_installed_that_is_there(prefixes: list[Path]) -> None:
    sim, exercises = prefixes
    (python,) = sim.glob("lib/python*/site-packages")
    for pattern in ("*.py", "live/*.py", "worlds/*.toml", "scenarios/*/*.toml"):
        ours = {file.relative_to(ROOT / "sim") for file in (ROOT / "sim").glob(pattern)}
        assert ours - {Path("setup.py")} <= {
            file.relative_to(python / "sim") for file in (python / "sim").glob(pattern)
        }
    share = exercises / "share" / "course_exercises"
    for pattern in ("launch/*.launch.py", "config/*.yaml", "rviz/*.rviz"):
        ours = {file.relative_to(ROOT / "exercises") for file in ROOT.glob(f"exercises/{pattern}")}
        assert ours
        assert ours == {file.relative_to(share) for file in share.glob(pattern)}
    assert {file.name for file in share.rglob("*_launch.py")} == {
        file for file in FILES if file.endswith("launch.py")
    }
    assert {file.name for file in (exercises / "lib" / "course_exercises").iterdir()} == PROGRAMS
    assert [file.name for file in (sim / "lib" / "course_sim").iterdir()] == ["mock_robot"]


@pytest.mark.parametrize(("name", "nodes"), [("sim", "sim/live"), ("exercises", "solutions")])
def test_manifests_name_what_is_imported(name: str, nodes: str) -> None:
    """Of ROS: what has no wheel, too, such as launch and tf2_msgs."""
    files = [*(ROOT / nodes).glob("*.py"), *(ROOT / nodes).glob("*/*.py"),
             *(ROOT / name).glob("launch/*.py")]  # fmt: skip
    imported = {module.partition(".")[0] for file in files for module in imports_of(file)}
    ros = {each for each in imported if ROS.search(each)}
    manifest = ET.parse(ROOT / name / "package.xml").getroot()
    named = {each.text or "" for each in manifest.findall("exec_depend")}
    assert "rclpy" in ros
    assert ros <= named


def imports_of(file: Path) -> Iterator[str]:
    """Yield the modules that a file imports, anywhere in it."""
    for node in ast.walk(ast.parse(file.read_text("utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            yield node.module


def test_every_program_is_found_in_its_package(prefixes: list[Path]) -> None:
    lines = ask(WHERE, environment(prefixes)).splitlines()
    found = dict(line.split(" ", 1) for line in lines)
    assert set(found) == PROGRAMS | {"mock_robot"}
    for name, place in found.items():
        attribute, file = place.split(" ", 1)
        owner = prefixes[0] if name == "mock_robot" else prefixes[1]
        assert Path(file).is_relative_to(owner), name
        assert f"def {attribute}(" in Path(file).read_text("utf-8"), name
        program = owner / "lib" / owner.name / name
        assert program.read_text("utf-8").startswith("#!/usr/bin/env python3\n"), program


def test_an_exercise_that_is_done_answers_a_scan(prefixes: list[Path], tmp_path: Path) -> None:
    agent = prefixes[1] / "lib" / "course_exercises" / "obstacle_avoidance_agent"
    with on_a_network_of_its_own() as network:
        variables = environment(prefixes, network)
        with running([str(agent)], variables, tmp_path):
            assert ask(SCANS, variables, "0.8") == "0.15"


def test_the_robot_scans_and_drives(prefixes: list[Path], tmp_path: Path) -> None:
    robot = prefixes[0] / "lib" / "course_sim" / "mock_robot"
    with on_a_network_of_its_own() as network:
        variables = environment(prefixes, network)
        with running([str(robot), "--lidar", "wide"], variables, tmp_path):
            assert ask(COMMANDS, variables) == "1080"


@pytest.mark.long
def test_a_release_of_one_exercise_builds_too(tmp_path: Path) -> None:
    from grader.authoring.release import release  # noqa: PLC0415

    pytest.importorskip("setuptools", reason="setuptools is not installed")
    release(tmp_path / "course", exercises=["goal_seeking"])
    prefix = tmp_path / "install" / "course_exercises"
    install(tmp_path / "course", "course_exercises", prefix)
    programs = (prefix / "lib" / "course_exercises").iterdir()
    assert [program.name for program in programs] == ["goal_seeking_agent"]
    assert (prefix / "share" / "course_exercises" / "launch" / "exercise.launch.py").is_file()
    assert (prefix / "share" / "course_exercises" / "rviz" / "course.rviz").is_file()
