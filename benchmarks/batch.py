"""What grading a class costs: CPU and wall time per submission, memory, and a peer's figure.

The peer is `nbgrader autograde` of a notebook with one trivial cell, in the same run; without
nbgrader that line says so.
"""

from __future__ import annotations

import argparse
import contextlib
import importlib.util
import os
import resource
import subprocess
import sys
import tempfile
from dataclasses import dataclass, replace
from pathlib import Path
from statistics import median

from grader.classroom.work import Unit, grade_unit
from grader.course.exercises import find_exercise

TICK = os.sysconf("SC_CLK_TCK")  # of the times in /proc [1/s]
FEW = 10  # the cost from here on must not grow
SETTINGS = "c = get_config()\nc.CourseDirectory.course_id = 'bench'\n"


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
    given = parser.parse_args()
    exercise = find_exercise(given.exercise)
    texts = {name: (exercise.solutions / name).read_bytes() for name in exercise.files}
    unit = Unit("warm", exercise.slug, texts, bags=False, field=given.field, trust=given.trust)
    before = _cpu_seconds()
    first = grade_unit(unit)
    cold = _cpu_seconds() - before
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
    _peer(cpu)
    return 0


def _cost(unit: Unit) -> _Cost:
    """Grade a unit; its grading, which would fill the memory that is measured, is not kept."""
    before = _cpu_seconds()
    wall = grade_unit(unit).wall_s
    size = int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")
    return _Cost(_cpu_seconds() - before, wall, size)


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


def _peer(cpu: float) -> None:
    if importlib.util.find_spec("nbgrader") is None:
        print("nbgrader: skipped, it is not installed (the extra `notebooks`); no ratio")
        return
    theirs = _nbgrader_seconds()
    print(
        f"nbgrader autograde, one trivial cell: {theirs:.2f} CPU s (a process each, as it is "
        f"run); ours is {cpu / theirs:.2f} times that"
    )


def _nbgrader_seconds() -> float:
    import nbformat  # noqa: PLC0415
    from nbformat import v4  # noqa: PLC0415

    cell = v4.new_code_cell("assert 1 + 1 == 2")
    cell.metadata["nbgrader"] = {
        "grade": True, "grade_id": "one", "locked": True, "points": 1, "schema_version": 3,
        "solution": False, "task": False,
    }  # fmt: skip
    spec = {"name": "python3", "display_name": "Python 3", "language": "python"}
    notebook = v4.new_notebook(cells=[cell], metadata={"kernelspec": spec})
    with tempfile.TemporaryDirectory(prefix="course-peer-") as name:
        folder = Path(name)
        (folder / "nbgrader_config.py").write_text(SETTINGS)
        for part in ("source/one", "submitted/ann/one"):
            (folder / part).mkdir(parents=True)
            nbformat.write(notebook, folder / part / "one.ipynb")
        command = [sys.executable, "-m", "nbgrader"]
        # nbgrader starts `alembic` by name, and finds it only in an environment that is activated
        programs = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
        environment = {**os.environ, "PATH": programs}
        quiet = {
            "cwd": folder,
            "env": environment,
            "stdout": subprocess.DEVNULL,
            "stderr": subprocess.DEVNULL,
        }
        subprocess.run([*command, "generate_assignment", "one"], check=True, **quiet)
        times = []
        for _ in range(3):
            before = _children_seconds()
            subprocess.run([*command, "autograde", "one", "--force"], check=True, **quiet)
            times.append(_children_seconds() - before)
        return median(times)


def _cpu_seconds() -> float:
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


def _children_seconds() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


if __name__ == "__main__":
    sys.exit(main())
