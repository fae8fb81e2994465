"""The judge has the machine's clocks, whatever a node's host makes of `time`."""

import ast
import math
import subprocess
import sys
from pathlib import Path

import pytest

from rclpy_virtual_time.link.real_clock import real_clock

ROOT = Path(__file__).resolve().parents[3]
ROOMS = (
    "grader/trial",
    "rclpy_virtual_time/link",
    "grader/grading",
    "grader/models",
    "grader/recording",
)
CLOCKS = {"time", "datetime"}
VIRTUAL = """
import os, time
from rclpy_virtual_time.link.real_clock import real_clock
from rclpy_virtual_time.host.virtual import threads
from rclpy_virtual_time.host.virtual.kernel import Kernel

began = time.monotonic()
threads.install(Kernel(), 0)
assert abs(time.time()) < 1e-3
assert 1e3 - 1e-3 < time.monotonic() < time.perf_counter() < 1e3 + 1e-3
for clock in (real_clock.monotonic, real_clock.perf_counter):
    assert 0.0 <= clock() - began < 60.0
assert real_clock.monotonic_ns() >= began * 1e9
before = real_clock.cpu_time(os.getpid())
sum(range(10**6))
assert real_clock.cpu_time(os.getpid()) > before
os._exit(0)
"""


@pytest.mark.parametrize("room", ROOMS)
def test_a_judges_room_reads_no_other_clock(room: str) -> None:
    files = sorted((ROOT / room).rglob("*.py"))
    assert [f"{room}/{file.name}" for file in files if _imported(file) & CLOCKS] == (
        ["rclpy_virtual_time/link/real_clock.py"] if room == "rclpy_virtual_time/link" else []
    )


def _imported(file: Path) -> set[str]:
    names: set[str] = set()
    for node in ast.walk(ast.parse(file.read_text("utf-8"))):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            names.add(node.module or "")
    return names


@pytest.mark.skipif(sys.platform != "linux", reason="CPU clocks of other processes")
def test_virtual_time_leaves_the_judges_clocks_alone() -> None:
    subprocess.run([sys.executable, "-c", VIRTUAL], cwd=ROOT, check=True, timeout=60)


def test_the_cpu_time_of_a_process_that_is_not_there_is_not_known() -> None:
    assert math.isnan(real_clock.cpu_time(2**22))  # no number of a process is so high
