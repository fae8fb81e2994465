"""Is a class that was killed, or spread over workers and a cluster, graded like an undisturbed one?

`python benchmarks/batch_survives.py --students 200 --kills 10` does it in full. Runs are compared
by the stable part of their results.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import random
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

from batch_class import make_class

from grader.classroom.store import Store, stable

COURSE = [sys.executable, "-m", "grader.cli", "autograde"]
DASK = [sys.executable, "-m", "dask"]


def main() -> int:
    """Grade the same class in several ways; 1 if any differs."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--students", type=int, default=8)
    parser.add_argument("--kills", type=int, default=3)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--canaries", type=int, default=25)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="course-batch-") as name:
        folder = Path(name)
        (folder / "in").mkdir()
        make_class(folder / "in", given.students)
        begin = [*COURSE, str(folder / "in"), "--no-bags", "--canaries", str(given.canaries)]
        runs = {}
        for label, workers in (("1 worker", 1), ("2 workers", 2)):
            out = folder / label.replace(" ", "")
            runs[label] = _timed(label, begin, out, "--workers", str(workers))
        expected = runs["2 workers"][1]
        killed = folder / "killed"
        for moment in _moments(given.seed, given.kills, expected):
            _kill_after(moment, [*begin, "--out", str(killed), "--workers", "2"])
        runs[f"2 workers, killed {given.kills} times"] = _timed(
            "killed, the last run", begin, killed, "--workers", "2"
        )
        runs["Dask, 2 workers, one killed"] = _on_dask(folder, begin)
    first = runs["1 worker"][0]
    different = 0
    for label, (results, _) in runs.items():
        unlike = sorted(key for key in first.keys() | results.keys()
                        if first.get(key) != results.get(key))  # fmt: skip
        different += bool(unlike)
        print(f"{label}: {len(results)} results, {len(unlike)} differ from 1 worker's")
        for key in unlike[:5]:
            print(f"  {key[0]}: {_difference(first.get(key), results.get(key))}")
    return 1 if different else 0


Results = dict[tuple[str, str], str]


def _difference(one: str | None, other: str | None) -> str:
    """Return the parts in which two results differ, cut short."""
    pairs = zip(json.loads(one or "[]"), json.loads(other or "[]"), strict=False)
    parts = [f"{str(a)[:200]} / {str(b)[:200]}" for a, b in pairs if a != b]
    return "; ".join(parts) or "one of them is missing"


def _timed(label: str, begin: list[str], out: Path, *options: str) -> tuple[Results, float]:
    start = time.monotonic()
    command = [*begin, "--out", str(out), *options]
    done = subprocess.run(command, stdout=subprocess.DEVNULL, check=False)
    took = time.monotonic() - start
    print(f"{label}: exit code {done.returncode}, {took:.0f} s", flush=True)
    return _results(out), took


def _results(out: Path) -> Results:
    with Store(out / "store.sqlite") as store:
        return {
            (result.student, result.exercise): json.dumps(stable(result))
            for result in store.results()
            if not result.canary
        }


def _moments(seed: int, kills: int, expected: float) -> list[float]:
    """Return after how long each run is killed [s]; the last ones find some work left."""
    chance = random.Random(seed)
    return [chance.uniform(0.3, max(2.0, 1.6 * expected / (kills + 1))) for _ in range(kills)]


def _kill_after(seconds: float, command: list[str]) -> None:
    with subprocess.Popen(command, stdout=subprocess.DEVNULL) as batch:
        with contextlib.suppress(subprocess.TimeoutExpired):
            batch.wait(seconds)
        batch.send_signal(signal.SIGKILL)
    print(f"killed -9 after {seconds:.1f} s", flush=True)


def _on_dask(folder: Path, begin: list[str]) -> tuple[Results, float]:
    file, out = folder / "scheduler.json", folder / "dask"
    worker = [*DASK, "worker", "--scheduler-file", str(file), "--nthreads", "1", "--no-nanny"]
    scheduler = [*DASK, "scheduler", "--scheduler-file", str(file), "--port", "0",
                 "--host", "127.0.0.1", "--no-dashboard"]  # fmt: skip
    with _process(scheduler, folder), _process(worker, folder), _process(worker, folder) as second:
        while not file.exists():
            time.sleep(0.1)
        start = time.monotonic()
        batch = subprocess.Popen(
            [*begin, "--out", str(out), "--dask", str(file)], stdout=subprocess.PIPE, text=True
        )
        assert batch.stdout is not None
        for count, _ in enumerate(batch.stdout):
            if count == 2:
                second.kill()
        batch.wait()
        took = time.monotonic() - start
        print(f"Dask, one of 2 workers killed: exit code {batch.returncode}, {took:.0f} s")
    return _results(out), took


@contextlib.contextmanager
def _process(command: list[str], folder: Path) -> Iterator[subprocess.Popen[bytes]]:
    with subprocess.Popen(command, cwd=folder, stderr=subprocess.DEVNULL) as process:
        try:
            yield process
        finally:
            process.kill()


if __name__ == "__main__":
    sys.exit(main())
