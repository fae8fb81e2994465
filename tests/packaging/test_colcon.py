"""Both packages with colcon itself: built, sourced and run as on a machine with ROS 2.

colcon is no part of the course's tools. `COURSE_COLCON=PATH_OF_COLCON pytest tests/packaging` runs
this, with a colcon from apt (python3-colcon-common-extensions) or pip (colcon-common-extensions).
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest
from ros_launch import started
from ros_workspace import (
    COMMANDS,
    MOVES,
    SCANS,
    ask,
    copy_sources,
    on_a_network_of_its_own,
    running,
    terminal,
)

COLCON = os.environ.get("COURSE_COLCON", "")
pytestmark = pytest.mark.skipif(
    not shutil.which(COLCON or "-"), reason="takes a minute: COURSE_COLCON=PATH_OF_COLCON"
)


@pytest.fixture(scope="module", params=["copied", "linked"])
def workspace(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A workspace in which both packages are built."""
    folder = tmp_path_factory.mktemp(request.param)
    copy_sources(folder / "src" / "course")
    linked = ["--symlink-install"] if request.param == "linked" else []
    said = colcon(folder, "build", *linked)
    assert "2 packages finished" in said
    return folder


def colcon(folder: Path, *arguments: str) -> str:
    """Run colcon in a workspace; return what it said."""
    done = subprocess.run(
        [COLCON, *arguments], cwd=folder, env=terminal(),
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False, timeout=300,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout
    return done.stdout


def sourced(folder: Path, more: Mapping[str, str]) -> dict[str, str]:
    """Return the variables of a terminal in which install/setup.sh has been sourced."""
    done = subprocess.run(
        ["sh", "-c", ". install/setup.sh && env -0"], cwd=folder,
        env=terminal(), capture_output=True, text=True, check=True,
    )  # fmt: skip
    pairs = (entry.partition("=")[::2] for entry in done.stdout.split("\0") if entry)
    return {**dict(pairs), **more}


def installed(folder: Path, package: str, name: str) -> list[str]:
    """Return the command of a program, as `ros2 run` runs it.

    In a linked workspace programs name the Python that colcon ran with (so the lesson calls it as
    `python3 -m colcon`); here colcon may have a Python of its own.
    """
    program = folder / "install" / package / "lib" / package / name
    return [sys.executable, str(program)] if is_linked(folder) else [str(program)]


def is_linked(folder: Path) -> bool:
    """Tell whether colcon could do what --symlink-install asks for: not with a new setuptools."""
    return any(folder.glob("build/course_sim/share/course_sim/hook/pythonpath_develop.*"))


def test_colcon_knows_both_packages(workspace: Path) -> None:
    listed = [line.split("\t") for line in colcon(workspace, "list").splitlines()]
    assert listed == [
        ["course_exercises", "src/course/exercises", "(ros.ament_python)"],
        ["course_sim", "src/course/sim", "(ros.ament_python)"],
    ]
    order = colcon(workspace, "graph").splitlines()
    assert order[0].startswith("course_sim"), "the exercises need the robot"


def test_an_exercise_answers_a_scan(workspace: Path, tmp_path: Path) -> None:
    program = installed(workspace, "course_exercises", "obstacle_avoidance_agent")
    with on_a_network_of_its_own() as network:
        variables = sourced(workspace, network)
        with running(program, variables, tmp_path):
            assert ask(SCANS, variables, "0.8") == "0.15"


def test_the_robot_of_the_workspace_drives(workspace: Path, tmp_path: Path) -> None:
    program = installed(workspace, "course_sim", "mock_robot")
    with on_a_network_of_its_own() as network:
        variables = sourced(workspace, network)
        with running([*program, "--scenario", "demo_wall"], variables, tmp_path):
            assert ask(COMMANDS, variables) == "360"


def test_what_the_launch_file_starts_works_together(
    workspace: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Robot and node as `ros2 launch` would start them, with their files of the install space."""
    packages = ("course_sim", "course_exercises")
    prefixes = [str(workspace / "install" / package) for package in packages]
    monkeypatch.setenv("AMENT_PREFIX_PATH", os.pathsep.join(prefixes))
    file = workspace / "install/course_exercises/share/course_exercises/launch/exercise.launch.py"
    nodes = started(file, exercise="obstacle_avoidance", use_sim_time="true", seed="5")
    with on_a_network_of_its_own() as network, ExitStack() as life:
        variables = sourced(workspace, network)
        for node in nodes:
            given = [words for each in node.parameters for words in ros_arguments(each)]
            command = installed(workspace, node.package or "", node.executable)
            command += [*node.arguments, "--ros-args", *given]
            life.enter_context(running(command, variables, tmp_path))
        assert ask(MOVES, variables) == "1", "one clock for all"


def ros_arguments(parameters: str | Mapping[str, Any]) -> list[str]:
    """Return what launch_ros makes of an entry of a node's parameters."""
    if isinstance(parameters, str):
        return ["--params-file", parameters]
    values = {name: json.dumps(value) for name, value in parameters.items()}
    return [word for name, value in values.items() for word in ("-p", f"{name}:={value}")]


def test_ros_finds_packages_and_their_files(workspace: Path) -> None:
    find = (
        "from ament_index_python.packages import get_package_share_directory as share\n"
        "from pathlib import Path\n"
        "print(Path(share('course_sim'), 'launch', 'sim.launch.py').is_file(),\n"
        "      Path(share('course_exercises'), 'config', 'ml_velocity.yaml').is_file())\n"
    )
    assert ask(find, sourced(workspace, {})) == "True True"


def test_an_edit_counts_at_once_in_a_linked_workspace(workspace: Path) -> None:
    where = "from course_exercises.obstacle_avoidance import obstacle_avoidance_agent as agent"
    file = Path(ask(f"{where}; print(agent.__file__)", sourced(workspace, {})))
    source = workspace / "src/course/exercises/obstacle_avoidance/obstacle_avoidance_agent.py"
    assert file.samefile(source) == is_linked(workspace)
    if workspace.name.startswith("linked") and not is_linked(workspace):
        pytest.skip("the setuptools that colcon runs with makes no links (it is 80 or newer)")
