"""Many claims graded by several processes at once; the answers come in the order of the claims."""

from __future__ import annotations

import atexit
import multiprocessing
import os
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from functools import cache
from typing import TYPE_CHECKING

from grader.host.sandbox.kernel_filters import die_with_parent
from grader.link.pool import ForkServerPool

if TYPE_CHECKING:
    from grader.authoring.proof import Claim
    from grader.grading.grading import Grading

PER_PROCESS = 100  # claims; then another process takes its place, and its memory is free


def gradings(claims: Sequence[Claim], workers: int) -> Iterator[Grading]:
    """Yield the grading of each claim, without its recordings.

    Parameters
    ----------
    workers
        How many processes grade.
    """
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(
        workers, context, die_with_parent, (os.getpid(),), max_tasks_per_child=PER_PROCESS
    ) as processes:
        yield from processes.map(_graded, claims)


def _graded(claim: Claim) -> Grading:
    from grader.authoring.proof import grade_claim  # noqa: PLC0415  (it imports this module)

    grading = grade_claim(claim, _servers().of(claim.exercise.libraries))
    return replace(grading, recordings=())


@cache
def _servers() -> ForkServerPool:
    """Return the fork servers of this process; they end with it."""
    servers = ForkServerPool(most=1)
    atexit.register(servers.close)
    return servers
