"""Is the exam the same for everybody? Grade right solutions with the worlds of many students.

References meet all students, variants and field checks the first few. Prints, for each solution,
how many gradings and runs there were and what failed, and for each scenario that differs from
student to student the spread of its difficulty (see sim/difficulty.py). What is done already is
read from `--keep FILE`, so an interrupted run goes on where it was. Ends with 1 if a solution
missed full marks anywhere.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import defaultdict
from collections.abc import Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import astuple, fields
from multiprocessing import get_context
from pathlib import Path

import msgspec
import numpy as np

from grader.authoring.fairness import Verdict, examine, right_solutions
from grader.course.exercises import all_exercises, find_exercise
from sim.difficulty import Difficulty

UNITS = {"free_way": " m", "width": " m", "clutter": "", "tortuosity": " rad/m"}


def main() -> int:
    """Examine and print; 1 if anything failed."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("exercises", nargs="*", help="all by default")
    parser.add_argument("--students", type=int, default=200, help="that references meet")
    parser.add_argument("--variants", type=int, default=20, help="students that variants meet")
    parser.add_argument("--field", type=int, default=20, help="students of the field checks")
    parser.add_argument("--jobs", type=int, default=2, help="processes")
    parser.add_argument("--keep", type=Path, help="read and add verdicts (JSON lines)")
    options = parser.parse_args()
    names = [find_exercise(name).slug for name in options.exercises]
    chosen = names or [exercise.slug for exercise in all_exercises()]

    begin = time.perf_counter()
    done = _read(options.keep)
    verdicts = []
    for slug in chosen:
        wanted = _wanted(slug, options.students, options.variants)
        mine, left = [], []
        for solution, student in wanted:
            verdict = done.get((solution, student))
            asked = student < options.field
            if verdict is None or verdict.unsure or (asked and not verdict.field):
                left.append((solution, student))
            else:
                mine.append(verdict)
        mine += _examine(slug, left, options.jobs, options.field, options.keep)
        _print(slug, mine)
        verdicts += mine
    bad = sum(bool(verdict.against) for verdict in verdicts)
    unsure = sum(bool(verdict.unsure) for verdict in verdicts)
    print(
        f"\n{len(verdicts)} gradings in {time.perf_counter() - begin:.0f} s "
        f"({sum(v.seconds for v in verdicts):.0f} s of work), {bad} without full marks, "
        f"{unsure} not judged in full because the machine stalled (run it again)"
    )
    return 1 if bad else 0


def _wanted(slug: str, students: int, variants: int) -> list[tuple[str, int]]:
    """Return the pairs of solution and student to examine."""
    return [
        (claim.name, student)
        for claim in right_solutions(slug)
        for student in range(students if claim.kind == "reference" else min(variants, students))
    ]


def _examine(
    slug: str, pairs: Sequence[tuple[str, int]], jobs: int, field: int, keep: Path | None
) -> list[Verdict]:
    """Examine the pairs in several processes, each with every n-th student of a solution."""
    students = defaultdict(list)
    for solution, student in pairs:
        students[solution].append(student)
    found = []
    with ProcessPoolExecutor(jobs, mp_context=get_context("spawn")) as pool:
        tasks = [
            pool.submit(_work, slug, solution, some[i::jobs], field, keep)
            for solution, some in students.items()
            for i in range(jobs)
            if some[i::jobs]
        ]
        for task in as_completed(tasks):
            found += task.result()
    return found


def _work(
    slug: str, solution: str, students: list[int], field: int, keep: Path | None
) -> list[Verdict]:
    """Examine one solution; write each verdict down as soon as it is there."""
    claim = next(claim for claim in right_solutions(slug) if claim.name == solution)
    found = []
    for verdict in examine(claim, students, field=field):
        found.append(verdict)
        if keep is not None:
            with keep.open("ab", buffering=0) as file:  # one write a line: lines stay whole
                file.write(msgspec.json.encode(verdict) + b"\n")
    return found


def _read(keep: Path | None) -> dict[tuple[str, int], Verdict]:
    if keep is None or not keep.exists():
        return {}
    lines = keep.read_bytes().splitlines()
    verdicts = [msgspec.json.decode(line, type=Verdict) for line in lines]
    return {(verdict.solution, verdict.student): verdict for verdict in verdicts}


def _print(slug: str, verdicts: Iterable[Verdict]) -> None:
    by_solution = defaultdict(list)
    for verdict in verdicts:
        by_solution[verdict.solution].append(verdict)
    print(f"\n{slug}")
    for solution, mine in sorted(by_solution.items()):
        bad = [verdict for verdict in mine if verdict.against]
        print(
            f"  {'!' if bad else ' '} {solution.partition('/')[2]:44} {len(mine):4} students  "
            f"{sum(v.runs for v in mine):5} runs ({sum(v.own for v in mine)} made)  "
            f"{len(bad)} failures  {sum(bool(v.unsure) for v in mine)} unsure  "
            f"{sum(v.seconds for v in mine):.0f} s"
        )
        for verdict in bad:
            print(f"      student {verdict.student}: " + "\n        ".join(verdict.against))
    _print_spread([verdict for mine in by_solution.values() for verdict in mine])
    sys.stdout.flush()


def _print_spread(verdicts: Iterable[Verdict]) -> None:
    """Print least, median and greatest of the four numbers, over the students."""
    measured: dict[str, dict[int, Difficulty]] = defaultdict(dict)
    for verdict in verdicts:
        for scenario, one in verdict.difficulties.items():
            measured[scenario][verdict.student] = one
    for scenario, ones in sorted(measured.items()):
        rows = np.array([astuple(one) for one in ones.values()])
        spread = ", ".join(
            f"{field.name} {low:.2f} … {middle:.2f} … {high:.2f}{UNITS[field.name]}"
            for field, low, middle, high in zip(
                fields(Difficulty), rows.min(0), np.median(rows, axis=0), rows.max(0), strict=True
            )
        )
        print(f"    {scenario:26} {spread}")


if __name__ == "__main__":
    sys.exit(main())
