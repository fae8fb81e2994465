"""What the grading of a reference costs: CPU time of the judge and of its hosts.

`make profile` prints it for some exercises (`EXERCISES="obstacle_avoidance ml_velocity"`), the
median of five cold gradings each. CPU time, not wall time, so that a busy machine hardly matters.
Where the time goes within a side, a sampling profiler tells: `py-spy record --subprocesses`.
"""

import json
import resource
import statistics
import subprocess
import sys

from grader.claims.claims import claims, grade_claim
from grader.course.exercises import all_exercises, find_exercise
from grader.launchers import fork_server

RUNS = 5
ONE = "--one"
# Of a host counts what it uses between a question and its answer; the fork server's are the imports
# and what Linux needs to start and end hosts.
COLUMNS = ("judge", "fork server", "hosts", "all", "simulated", "ms per simulated s", "us per turn")


def main(arguments: list[str]) -> None:
    """Print a table of the exercises that are named, or of all."""
    if arguments[:1] == [ONE]:
        print(json.dumps(_grading(arguments[1])))
        return
    print(f"CPU time of a cold grading [s], median of {RUNS}")
    print(f"{'':20}" + "".join(f"{column:>19}" for column in COLUMNS))
    for slug in arguments or [exercise.slug for exercise in all_exercises()]:
        runs = [_run(slug) for _ in range(RUNS)]
        medians = [statistics.median(run[column] for run in runs) for column in COLUMNS]
        print(f"{slug:20}" + "".join(f"{median:19.2f}" for median in medians), flush=True)


def _run(slug: str) -> dict[str, float]:
    command = [sys.executable, __file__, ONE, slug]
    done = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True)
    found: dict[str, float] = json.loads(done.stdout)
    return found


def _grading(slug: str) -> dict[str, float]:
    """Grade a reference in this process; return what it has cost since it began."""
    exercise = find_exercise(slug)
    reference = next(claim for claim in claims(exercise) if claim.kind == "reference")
    with fork_server(libraries=exercise.libraries) as server:
        grading = grade_claim(reference, server)
    if not grading.field_ready:  # it was repeated, too
        raise SystemExit(f"{slug}: {grading.score} points, not full marks: a busy machine?")
    judge, children = (
        used.ru_utime + used.ru_stime
        for used in map(resource.getrusage, (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    )
    virtual = [each for each in grading.recordings if each.training is None]
    hosts = sum(float(each.compute.cpu.sum()) for each in virtual)
    simulated = sum(each.duration_s for each in virtual)
    turns = sum(len(each.compute.cpu) - 1 for each in virtual)
    each_turn = sum(float(each.compute.cpu[1:].sum()) for each in virtual) / turns
    whole = judge + children
    figures = (judge, children - hosts, hosts, whole, simulated)
    ratios = (whole / simulated * 1e3, each_turn * 1e6)
    return dict(zip(COLUMNS, (*figures, *ratios), strict=True))


if __name__ == "__main__":
    main(sys.argv[1:])
