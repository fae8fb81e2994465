"""What would fail on this machine once a class is graded, told before: `course doctor`."""

from __future__ import annotations

import contextlib
import importlib.metadata
import os
import re
import resource
import tempfile
from collections.abc import Collection, Iterator
from pathlib import Path

from rclpy_virtual_time.host.sandbox.amounts import MAX_FOLDER
from rclpy_virtual_time.host.sandbox.layers import MOUNTS

MIB = 2**20
SPACE = 4 * MAX_FOLDER  # [bytes] free for folders of submissions
FILES = 20_000  # free for the same
MEMORY = 1024 * MIB  # [bytes] that a worker with PyTorch, and a node, may take
SHARED = 64 * MIB  # [bytes] of /dev/shm, where hosts have none of their own
DESCRIPTORS = 512
SHM = Path("/dev/shm")
MEMINFO, CGROUP = Path("/proc/meminfo"), Path("/sys/fs/cgroup")
CONSTRAINTS = Path(__file__).resolve().parents[2] / "constraints.txt"
DECIDE = (  # distributions on which a verdict may depend
    "numpy", "pymunk", "time-machine", "ros-jazzy-rclpy", "ros-jazzy-rmw-fastrtps-cpp",
    "ros-kilted-rclpy", "ros-kilted-rmw-fastrtps-cpp",
    "scikit-learn", "onnx", "onnxruntime", "skl2onnx", "torch", "keras",
)  # fmt: skip


def trouble(layers: Collection[str]) -> tuple[str, ...]:
    """Return a sentence for each thing that a class would fail on, and what to do about it."""
    folder = Path(tempfile.gettempdir())
    return (
        *_space(folder, SPACE, "submissions work there; set TMPDIR to a larger disk"),
        *([] if MOUNTS in layers else _space(SHM, SHARED, "each node needs some of it; in Docker "
                                             "give --shm-size=1g")),
        *_memory(),
        *_descriptors(),
        *_versions(),
    )  # fmt: skip


def _space(folder: Path, wanted: int, why: str) -> Iterator[str]:
    try:
        found = os.statvfs(folder)
    except OSError as error:
        yield f"{folder} can't be used ({error.strerror}): {why}."
        return
    free = found.f_bavail * found.f_frsize
    if free < wanted:
        yield f"{folder} has {free // MIB:,} MiB free, expected {wanted // MIB:,}: {why}."
    elif found.f_files and found.f_favail < FILES and wanted == SPACE:
        yield f"{folder} has room for {found.f_favail:,} files, expected {FILES:,}: {why}."
    if not os.access(folder, os.W_OK | os.X_OK):
        yield f"{folder} can't be written to: {why}."


def _memory() -> Iterator[str]:
    """Look at what the kernel has, and at the limit of a container."""
    found = []
    with contextlib.suppress(OSError, ValueError):
        if said := re.search(r"MemAvailable:\s*(\d+) kB", MEMINFO.read_text("utf-8")):
            found.append(int(said[1]) * 1024)
    with contextlib.suppress(OSError, ValueError):  # "max" without a limit
        limit = int((CGROUP / "memory.max").read_text("utf-8"))
        found.append(limit - int((CGROUP / "memory.current").read_text("utf-8")))
    if found and min(found) < MEMORY:
        yield (
            f"{max(0, min(found)) // MIB:,} MiB of memory are left, expected {MEMORY // MIB:,} for "
            "each worker: grade with fewer, or end other programs."
        )


def _descriptors() -> Iterator[str]:
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    if soft != resource.RLIM_INFINITY and soft < DESCRIPTORS:
        yield f"A process may open {soft} files, expected {DESCRIPTORS}: ulimit -n {hard}."


def _versions() -> Iterator[str]:
    """Compare what is installed with what the course is tested with."""
    try:
        files = CONSTRAINTS.parent.glob("constraints*.txt")  # those of Kilted have other names
        lines = [line for file in files for line in file.read_text("utf-8").splitlines()]
    except OSError:
        return
    tested = dict(line.split("==", 1) for line in lines if "==" in line)
    other = []
    for name in DECIDE:
        with contextlib.suppress(importlib.metadata.PackageNotFoundError):
            here = importlib.metadata.version(name)
            if name in tested and here.partition("+")[0] != tested[name].partition(";")[0].strip():
                other.append(f"{name} {here} (tested: {tested[name]})")
    if other:
        yield (
            f"Scores may differ from those elsewhere: {', '.join(other)}; install with "
            "--constraint constraints.txt."
        )
