"""Is the exam the same for everybody? Grade the references with the worlds of many students.

Prints the scores (all must be full) and the spread of the worlds' difficulty.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter
from dataclasses import fields

import numpy as np

from grader.exercises import Exercise, all_exercises, find_exercise
from grader.grading import grade_live
from grader.launch import Nursery
from grader.plugin import PASS
from grader.students import student_seed
from grader.submission import find_submission
from grader.trials import trial_seed
from sim.difficulty import Difficulty, difficulty
from sim.messages import EPOCH_NS
from sim.scenario import load_scenario

SECRET = b"not a secret: for measuring only"


def main() -> int:
    """Print a table per exercise; 1 if any student could not get full marks."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("exercises", nargs="*")
    parser.add_argument("--students", type=int, default=200)
    options = parser.parse_args()
    chosen = [find_exercise(name) for name in options.exercises] or all_exercises()
    with Nursery(EPOCH_NS) as nursery:
        return max(_measure(exercise, options.students, nursery) for exercise in chosen)


def _measure(exercise: Exercise, students: int, nursery: Nursery) -> int:
    file = exercise.solutions / exercise.files[0]
    submission = find_submission(file, exercise.files[0], exercise.files[1:])
    seeds = [student_seed(SECRET, f"student {i}", exercise.slug) for i in range(students)]
    start = time.perf_counter()

    scores: Counter[int] = Counter()
    lost: Counter[str] = Counter()
    for seed in seeds:
        grading = grade_live(exercise, submission, nursery, file=file.name, seed=seed)
        scores[grading.score] += 1
        lost.update(check.id for check in grading.checks if check.outcome != PASS)
    elapsed = time.perf_counter() - start
    print(f"{exercise.slug}: {students} students, scores {dict(scores)}, lost {dict(lost)}")
    print(f"  {elapsed / students:.2f} s each")
    _print_spread([recording.name for recording in grading.recordings], seeds)
    return 0 if not lost else 1


def _print_spread(scenarios: list[str], seeds: list[int]) -> None:
    for name in scenarios:
        scenario = load_scenario(name)
        measured = [difficulty(scenario, trial_seed(scenario, seed)) for seed in seeds[:50]]
        columns = {
            field.name: np.array([getattr(one, field.name) for one in measured])
            for field in fields(Difficulty)
        }
        spread = ", ".join(
            f"{key} {values.mean():.2f} ± {values.std():.2f}" for key, values in columns.items()
        )
        print(f"  {name:28} {spread}")


if __name__ == "__main__":
    sys.exit(main())
