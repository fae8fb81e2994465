"""Programs that print what rclpy does print the same on the real rclpy and on the portable one."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from rclpy_virtual_time import ForkServer, NoRos, ProgramStart, RosEnvironment, run_programs
from rclpy_virtual_time.link.settings import EPOCH

SCRIPTS = sorted((Path(__file__).parent / "scripts").glob("*.py"))
QUICK = ("messages", "services")  # in `make test`
HOSTED = ("futures",)  # in virtual time, too
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


def said_in_a_host(script: Path, ros: RosEnvironment) -> list[str]:
    """Run a program in virtual time; return the lines that it prints."""
    with ForkServer(EPOCH, ros) as server:
        run = run_programs(server, script.parent, [ProgramStart(script.name)], until=60 * 10**9)
    assert run.ended and run.ended.kind == "returned", run
    return [line.text for line in run.log if line.level == "stdout"]


@pytest.mark.parametrize(
    "script",
    [
        pytest.param(path, id=path.stem, marks=() if path.stem in QUICK else pytest.mark.long)
        for path in SCRIPTS
    ],
)
def test_the_same_is_printed(script: Path, worker_id: str = "") -> None:
    try:
        real, portable = RosEnvironment.find(), RosEnvironment.portable()
    except NoRos as error:
        pytest.skip(f"nothing to compare with: {error}")
    domain = 60 + os.getpid() % 40
    expected = said(script, list(real.python_path), real.variables(), domain)
    found = said(script, [*portable.python_path, ROOT], portable.variables(), domain)
    assert found.splitlines() == expected.splitlines()
    assert len(expected.splitlines()) > 10
    for ros in (real, portable) if script.stem in HOSTED else ():
        assert said_in_a_host(script, ros) == expected.splitlines()
