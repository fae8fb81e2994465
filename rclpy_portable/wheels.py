"""Which of ROS's wheels the runtime takes Python from, and how it comes by them.

The wheels are for Linux on x86_64, but a wheel is an archive: its Python can be read on any system.
Only that is taken; what is native stays behind. All of it is under the Apache License 2.0.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

VERSIONS = {  # distribution: version; the same as in constraints.txt (a test compares)
    "ros-rclpy": "7.1.6",
    "ros-ament-index-python": "1.8.1",
    "ros-rpyutils": "0.4.2",
    "ros-rosidl-adapter": "4.6.6",
    "ros-rosidl-parser": "4.6.6",
    "ros-action-msgs": "2.0.3",
    "ros-actionlib-msgs": "5.3.6",
    "ros-builtin-interfaces": "2.0.3",
    "ros-diagnostic-msgs": "5.3.6",
    "ros-geometry-msgs": "5.3.6",
    "ros-lifecycle-msgs": "2.0.3",
    "ros-nav-msgs": "5.3.6",
    "ros-rcl-interfaces": "2.0.3",
    "ros-rosgraph-msgs": "2.0.3",
    "ros-sensor-msgs": "5.3.6",
    "ros-service-msgs": "2.0.3",
    "ros-shape-msgs": "5.3.6",
    "ros-std-msgs": "5.3.6",
    "ros-std-srvs": "5.3.6",
    "ros-stereo-msgs": "5.3.6",
    "ros-trajectory-msgs": "5.3.6",
    "ros-type-description-interfaces": "2.0.3",
    "ros-unique-identifier-msgs": "2.5.0",
    "ros-visualization-msgs": "5.3.6",
}
PACKAGES = tuple(name.removeprefix("ros-").replace("-", "_") for name in VERSIONS)
PLATFORM = ("--platform", "manylinux_2_28_x86_64", "--implementation", "cp")
PYTHON = "3.12"  # a Python that there are wheels for; their Python files are all the same


class DownloadFailed(Exception):
    """The wheels can't be had."""


def download(folder: Path) -> list[Path]:
    """Fetch the wheels into a folder, with this Python's pip; return their paths.

    Raises DownloadFailed: pip says why.
    """
    wanted = [f"{name}=={version}" for name, version in VERSIONS.items()]
    command = [
        sys.executable, "-m", "pip", "--disable-pip-version-check", "--quiet", "download",
        "--no-deps", "--only-binary", ":all:", "--python-version", PYTHON, *PLATFORM,
        "--dest", str(folder), *wanted,
    ]  # fmt: skip
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        lines = done.stderr.strip().splitlines() or ["pip said nothing"]
        raise DownloadFailed(f"ROS's wheels could not be fetched with pip: {lines[-1]}")
    return sorted(folder.glob("*.whl"))
