"""Programs that print what rclpy does print the same on the real rclpy and on the portable one."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from grader.errors import InputError
from grader.link.ros_environment import find_ros, portable_ros

SCRIPTS = sorted((Path(__file__).parent / "scripts").glob("*.py"))
QUICK = ("messages", "services")  # in `make test`
ROOT = Path(__file__).resolve().parents[2]
ADDRESS = re.compile(r"0x[0-9a-f]+")


def said(script: Path, paths: list[Path], variables: dict[str, str], domain: int) -> str:
    """Run a program with one of the two; return what it prints."""
    environment = {
        **os.environ,
        **variables,
        "PYTHONPATH": os.pathsep.join(map(str, paths)),
        "ROS_DOMAIN_ID": str(domain),
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
        "PYTHONHASHSEED": "0",
    }
    done = subprocess.run(
        [sys.executable, "-B", str(script)],
        env=environment, capture_output=True, text=True, timeout=120, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr[-3000:]
    return ADDRESS.sub("0x", done.stdout)


@pytest.mark.parametrize(
    "script",
    [
        pytest.param(path, id=path.stem, marks=() if path.stem in QUICK else pytest.mark.long)
        for path in SCRIPTS
    ],
)
def test_the_same_is_printed(script: Path, worker_id: str = "") -> None:
    try:
        real, portable = find_ros(), portable_ros()
    except InputError as error:
        pytest.skip(f"nothing to compare with: {error}")
    domain = 60 + os.getpid() % 40
    expected = said(script, list(real.python_path), real.variables(), domain)
    found = said(script, [*portable.python_path, ROOT], portable.variables(), domain)
    assert found.splitlines() == expected.splitlines()
    assert len(expected.splitlines()) > 10
