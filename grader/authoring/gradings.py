"""Many claims graded by several processes at once; the answers come in the order of the claims."""

import atexit
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from functools import cache, partial

from grader.claims.claims import Claim, grade_claim
from grader.grading.grading import Grading
from grader.launchers import ForkServerPool, launcher_pool
from grader.processes import end_with_parent, own_processes
from grader.trial.kept import KeptRecordings

# Claims of a process; then others take over, and the memory is free. (The executor's own
# max_tasks_per_child deadlocks in CPython 3.11: python/cpython#115634.)
PER_PROCESS = 50


def gradings(
    claims: Sequence[Claim], workers: int, *, kept: KeptRecordings | None = None
) -> Iterator[Grading]:
    """Yield the grading of each claim, without its recordings.

    Parameters
    ----------
    workers
        How many processes grade.
    kept
        Recordings of earlier runs.
    """
    graded = partial(_graded, kept=kept)
    at_once = PER_PROCESS * workers
    for begin in range(0, len(claims), at_once):
        with ProcessPoolExecutor(workers, own_processes(), end_with_parent) as processes:
            yield from processes.map(graded, claims[begin : begin + at_once])


def _graded(claim: Claim, *, kept: KeptRecordings | None) -> Grading:
    servers = _servers().of(claim.exercise.libraries)
    grading = grade_claim(claim, servers, kept=kept)
    return replace(grading, recordings=())


@cache
def _servers() -> ForkServerPool:
    """Return the fork servers of this process; they end with it."""
    servers = launcher_pool(most=1)
    atexit.register(servers.close)
    return servers
