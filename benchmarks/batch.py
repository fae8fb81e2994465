"""What grading a class costs: CPU and wall time per submission, memory, growth.

With --dask whole classes are graded on a cluster on this machine, by `course autograde --dask` as
an instructor calls it, and nothing else is measured. Other graders' figures: peers.py.
"""

from __future__ import annotations

import argparse
import contextlib
import itertools
import os
import resource
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from statistics import median

from grader.classroom.work import Unit, grade_unit
from grader.course.exercises import find_exercise

TICK = os.sysconf("SC_CLK_TCK")  # of the times in /proc [1/s]
FEW = 10  # the cost from here on must not grow
CHEAP = """import rclpy
from rclpy.node import Node

rclpy.init()
node = Node("obstacle_avoidance_agent")
"""  # ends at once: what remains is the price of grading


@dataclass(frozen=True)
class _Cost:
    """What grading one submission took."""

    cpu_s: float  # [s] of the worker and its descendants
    wall_s: float  # [s]
    memory: int  # [bytes] the worker's afterwards, resident


def main() -> int:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--submissions", type=int, default=12)
    parser.add_argument("--exercise", default="obstacle_avoidance")
    parser.add_argument("--field", action="store_true", help="the field checks too")
    parser.add_argument("--trust", action="store_true")
    parser.add_argument(
        "--dask", type=int, nargs="+", metavar="COUNT", help="classes of so many cheap nodes"
    )
    parser.add_argument("--workers", type=int, nargs="+", default=[1, 2], help="with --dask")
    given = parser.parse_args()
    if given.dask:
        for workers, count in itertools.product(given.workers, given.dask):
            print(_class_on_dask(count, workers), flush=True)
        return 0
    exercise = find_exercise(given.exercise)
    unit = replace(reference_unit(exercise.slug), field=given.field, trust=given.trust)
    before = cpu_seconds()
    first = grade_unit(unit)
    cold = cpu_seconds() - before
    if first.grading is None:
        print(first.problem)
        return 1
    results = [_cost(replace(unit, student=str(n))) for n in range(given.submissions)]
    cpu, wall = median(r.cpu_s for r in results), median(r.wall_s for r in results)
    load = os.getloadavg()[0]
    print(
        f"{exercise.slug} in full ({'core and field' if given.field else 'core'}, "
        f"{len(first.grading['recordings'])} trials), "
        f"one warm worker, {len(results)} submissions, load {load:.1f}: "
        f"{cpu:.2f} CPU s and {wall:.2f} s each (medians); the first, cold: {cold:.2f} CPU s"
    )
    _growth(results)
    return 0


def reference_unit(name: str) -> Unit:
    """Return an exercise's reference, as a student's submission."""
    exercise = find_exercise(name)
    texts = {file: (exercise.solutions / file).read_bytes() for file in exercise.files}
    return Unit("warm", exercise.slug, texts, bags=False)


def _cost(unit: Unit) -> _Cost:
    """Grade a unit; its grading, which would fill the memory that is measured, is not kept."""
    before = cpu_seconds()
    wall = grade_unit(unit).wall_s
    size = int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")
    return _Cost(cpu_seconds() - before, wall, size)


def _growth(results: list[_Cost]) -> None:
    if len(results) <= FEW:
        print(f"growth: not measured with {len(results)} submissions, at least {FEW + 1} needed")
        return
    early, late = results[:FEW], results[FEW:]
    cost = median(r.cpu_s for r in late) / median(r.cpu_s for r in early)
    megabytes = [r.memory / 2**20 for r in (results[0], results[FEW - 1], results[-1])]
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(
        f"submissions {FEW + 1} to {len(results)} cost {cost:.2f} times the first {FEW}; "
        f"judge's memory after 1, {FEW} and {len(results)}: "
        + ", ".join(f"{size:.0f}" for size in megabytes)
        + f" MiB (peak {peak:.0f})"
    )


def _class_on_dask(count: int, workers: int) -> str:
    """Grade a class on a scheduler and workers of its own; say what it took."""
    with (
        tempfile.TemporaryDirectory(prefix="course-dask-") as name,
        contextlib.ExitStack() as stack,
    ):
        folder, address = Path(name), Path(name) / "scheduler.json"
        for number in range(count):
            handed_in = folder / "in" / f"student{number:05}"
            handed_in.mkdir(parents=True)
            text = f"# {number}\n{CHEAP}"
            (handed_in / "obstacle_avoidance_agent.py").write_text(text)
        scheduler, worker = (
            stack.enter_context(_dask(part, "--scheduler-file", str(address), *more))
            for part, more in (
                ("scheduler", ["--host", "127.0.0.1", "--port", "0", "--dashboard-address", ":0"]),
                ("worker", ["--nthreads", "1", "--nworkers", str(workers), "--no-dashboard"]),
            )
        )
        words = ["autograde", "in", "--out", "out", "--no-bags", "--dask", str(address)]
        command = [str(Path(sys.executable).with_name("course")), *words]
        deadline = time.monotonic() + 60
        while not address.is_file() and time.monotonic() < deadline:
            time.sleep(0.1)
        begin = time.monotonic()
        client = subprocess.Popen(command, cwd=folder, stdout=subprocess.DEVNULL)
        _, status, used = os.wait4(client.pid, 0)
        wall = time.monotonic() - begin
        client.returncode = os.waitstatus_to_exitcode(status)
        own = used.ru_utime + used.ru_stime
        theirs = [sum(map(_ticks, _family(pid))) / TICK for pid in (scheduler, worker)]
        peaks = [max(map(_peak, _family(pid))) for pid in (scheduler, worker)]
        return (
            f"{count} cheap nodes, {workers} workers, load {os.getloadavg()[0]:.1f}, exit code "
            f"{client.returncode}: {wall:.0f} s, {wall / count:.3f} s each; CPU each: workers "
            f"{theirs[1] / count:.3f}, scheduler {theirs[0] / count:.4f}, client "
            f"{own / count:.4f} s; peak MiB: scheduler {peaks[0]:.0f}, client "
            f"{used.ru_maxrss / 1024:.0f}, largest process of a worker {peaks[1]:.0f}"
        )


@contextlib.contextmanager
def _dask(*words: str) -> Iterator[int]:
    """Run a part of Dask; yield its process's id."""
    command = [sys.executable, "-m", "distributed.cli.dask_" + words[0], *words[1:]]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        yield process.pid
    finally:
        process.send_signal(signal.SIGTERM)
        process.wait()


def _peak(pid: int) -> float:
    """Return the most memory that a process has had [MiB]."""
    with contextlib.suppress(OSError, StopIteration):
        lines = Path(f"/proc/{pid}/status").read_text().splitlines()
        return int(next(line for line in lines if line.startswith("VmHWM")).split()[1]) / 1024
    return 0.0


def cpu_seconds() -> float:
    """Return the CPU time of this process and its descendants, dead ones included [s].

    The host's fork server lives on from unit to unit, so `os.times` does not have the nodes.
    """
    return sum(_ticks(pid) for pid in _family(os.getpid())) / TICK


def _family(pid: int) -> list[int]:
    """Return a process and its living descendants."""
    found = [pid]
    with contextlib.suppress(OSError):
        for task in Path(f"/proc/{pid}/task").iterdir():
            for child in (task / "children").read_text().split():
                found += _family(int(child))
    return found


def _ticks(pid: int) -> int:
    """Return the CPU time of a process and of the children it has waited for [1/TICK s]."""
    try:
        after_name = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return 0
    return sum(map(int, after_name[11:15]))


if __name__ == "__main__":
    sys.exit(main())
