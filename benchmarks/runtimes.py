"""The real rclpy and the portable runtime side by side: lock step, and gradings of references.

    python benchmarks/runtimes.py [EXERCISE …]

Both runtimes have a fork server here, so that nothing but the runtime differs; the third column is
the portable launcher, with a process for each trial. Runs take turns, because a machine has moods.
"""

from __future__ import annotations

import argparse
import statistics
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import msgspec
from peers import ECHO, SPIN

from grader.authoring.claims import claims, grade_claim
from grader.course.exercises import all_exercises, find_exercise
from grader.course.submission import Submission
from grader.errors import InputError
from grader.link.hosts import ForkServer
from grader.link.launcher import Launcher
from grader.link.practice import PracticeServer
from grader.link.ros_environment import find_ros, portable_ros
from grader.trial.virtual_time import run_trial
from sim.messages import EPOCH_NS
from sim.scenario_files import load_scenario

RUNS = 2
SECONDS = 30.0  # simulated
KINDS = ("real", "portable", "launcher")


def started(kind: str, libraries: tuple[str, ...] = ()) -> ForkServer | PracticeServer:
    """Start what starts hosts of a kind."""
    if kind == "launcher":
        return PracticeServer(EPOCH_NS, libraries=libraries)
    ros = find_ros() if kind == "real" else portable_ros()
    return ForkServer(EPOCH_NS, ros, libraries=libraries)


def side_by_side(libraries: tuple[str, ...], work: Callable[[Launcher], object]) -> list[float]:
    """Return how long some work takes with each [s], the median of some runs."""
    spent: dict[str, list[float]] = {kind: [] for kind in KINDS}
    servers = {kind: started(kind, libraries) for kind in KINDS}
    try:
        for run in range(RUNS + 1):
            for kind, server in servers.items():
                begun = time.perf_counter()
                work(server)
                if run:  # the first one warms up
                    spent[kind].append(time.perf_counter() - begun)
    finally:
        for server in servers.values():
            server.__exit__()
    return [statistics.median(spent[kind]) for kind in KINDS]


def table(name: str, seconds: list[float]) -> None:
    """Print a row: seconds, and the ratio to the real one."""
    real = seconds[0]
    columns = "".join(f"{value:9.2f} s {value / real:5.2f}" for value in seconds)
    print(f"{name:24}{columns}", flush=True)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument(
        "exercises", nargs="*", metavar="EXERCISE", help="name or number; all by default"
    )
    try:
        exercises = [find_exercise(name) for name in parser.parse_args().exercises]
    except InputError as error:
        parser.error(str(error))
    print(f"{'':24}" + "".join(f"{kind:>17}" for kind in KINDS))
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "echo.py")
        file.write_text(ECHO + SPIN, "utf-8")
        scenario = msgspec.structs.replace(load_scenario("demo_wall"), duration=SECONDS)
        table(f"lock step, {SECONDS:.0f} s", side_by_side(
            (), lambda server: run_trial(Submission(file), scenario, server)))  # fmt: skip
    for exercise in exercises or all_exercises():
        reference = next(iter(claims(exercise)))
        table(exercise.slug, side_by_side(
            exercise.libraries, lambda server, claim=reference: grade_claim(claim, server)))  # type: ignore[misc]  # fmt: skip


if __name__ == "__main__":
    main()
