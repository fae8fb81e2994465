"""Both packages with colcon itself: built, sourced and run as on a machine with ROS 2.

colcon is no part of the course's tools. `COURSE_COLCON=PATH_OF_COLCON pytest tests/packaging` runs
this, with a colcon from apt (python3-colcon-common-extensions) or pip (colcon-common-extensions).
"""

import os
import shutil
import subprocess
from pathlib import Path

import pytest
from ros_workspace import (
    COMMANDS,
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


def said(command: list[str], folder: Path) -> str:
    done = subprocess.run(
        command, cwd=folder, env=terminal(), capture_output=True, text=True, check=False,
        timeout=300,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout + done.stderr


def test_colcon_builds_both_packages_and_their_programs_run(tmp_path: Path) -> None:
    copy_sources(tmp_path / "src" / "course")
    assert "2 packages finished" in said([COLCON, "build"], tmp_path)
    found = said(["sh", "-c", ". install/setup.sh && env -0"], tmp_path)
    variables = dict(entry.partition("=")[::2] for entry in found.split("\0") if entry)
    programs = {name: tmp_path / "install" / name / "lib" / name
                for name in ("course_sim", "course_exercises")}  # fmt: skip
    with on_a_network_of_its_own() as network:
        agent = programs["course_exercises"] / "obstacle_avoidance_agent"
        with running([str(agent)], {**variables, **network}, tmp_path):
            assert ask(SCANS, {**variables, **network}, "0.8") == "0.15"
    with on_a_network_of_its_own() as network:
        robot = programs["course_sim"] / "mock_robot"
        with running([str(robot), "--scenario", "demo_wall"], {**variables, **network}, tmp_path):
            assert ask(COMMANDS, {**variables, **network}) == "360"
