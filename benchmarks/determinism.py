"""The same submission graded often, also on a loaded machine: are the recordings equal?"""

from __future__ import annotations

import contextlib
import subprocess
import sys
import time
from collections.abc import Iterator

from grader.course.exercises import Exercise, all_exercises, find_exercise
from grader.course.submission import find_submission
from grader.grading.grading import grade_submission
from grader.link.hosts import ForkServer
from sim.messages import EPOCH_NS

GRADINGS = 20
BUSY_LOOPS = 2


def main() -> int:
    """Grade the references (or those named) 20 times, half under load; 1 if any differs."""
    different = 0
    with ForkServer(EPOCH_NS) as forkserver:
        for exercise in [find_exercise(name) for name in sys.argv[1:]] or all_exercises():
            different += _grade_often(exercise, forkserver)
    return 1 if different else 0


def _grade_often(exercise: Exercise, forkserver: ForkServer) -> int:
    file = exercise.solutions / exercise.files[0]
    submission = find_submission(file, exercise.files[0], exercise.files[1:])
    seen: dict[str, set[str]] = {}
    scores = set()
    times: dict[bool, float] = {}
    for loaded in (False, True):
        start = time.perf_counter()
        with _load(loaded):
            for _ in range(GRADINGS // 2):
                grading = grade_submission(
                    exercise, submission, forkserver, file=file.name, field=True
                )
                scores.add(grading.score)
                for recording in grading.recordings:
                    seen.setdefault(recording.name, set()).add(recording.digest())
        times[loaded] = (time.perf_counter() - start) / (GRADINGS // 2)
    different = [name for name, digests in seen.items() if len(digests) > 1]
    print(
        f"{exercise.slug}: {GRADINGS} gradings of {len(seen)} recordings, scores {sorted(scores)}; "
        f"recordings that differ: {different or 'none'}; "
        f"{times[False]:.2f} s each, {times[True]:.2f} s under load "
        f"({times[True] / times[False]:.1f} times)"
    )
    return len(different)


@contextlib.contextmanager
def _load(loaded: bool) -> Iterator[None]:
    count = BUSY_LOOPS if loaded else 0
    busy = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(count)]
    try:
        yield
    finally:
        for process in busy:
            process.kill()
            process.wait()


if __name__ == "__main__":
    sys.exit(main())
