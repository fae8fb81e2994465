"""Run units on workers: processes on this machine, or a Dask cluster.

Both are `concurrent.futures` executors, so one loop serves both. Each local worker is an executor
with a single process, so that when one dies it is known which unit it ran.
"""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable, Iterator
from concurrent.futures import (
    FIRST_COMPLETED,
    BrokenExecutor,
    Executor,
    Future,
    ProcessPoolExecutor,
    wait,
)
from pathlib import Path
from typing import Any

from grader.classroom.queue.work import Unit, UnitResult, grade_unit
from grader.errors import GraderError, InputError
from grader.grading.handed_in import isolation_problem
from grader.processes import end_with_parent, own_processes

DASK_RETRIES = 2
MAX_UNITS = 100  # of a local worker, which is then replaced, so that no leak adds up
CONNECT_LIMIT = 20  # [s]


@contextlib.contextmanager
def open_workers(count: int, dask: str = "") -> Iterator[Workers]:
    """Start `count` workers on this machine, or join those of a Dask cluster, for the block.

    `dask` is a scheduler's address or file.

    Raises InputError: there is no such scheduler, or Dask is not installed.
    """
    workers = DaskWorkers(dask) if dask else LocalWorkers(count)
    try:
        yield workers
    except BaseException:
        workers.close(now=True)
        raise
    workers.close(now=False)


def run(
    workers: Workers,
    next_unit: Callable[[bool], Unit | None],
    done: Callable[[Unit, UnitResult], None],
) -> None:
    """Run units until none is left and all are done.

    `next_unit` is told whether anything is running, and returns None if nothing may start now.
    """
    running: dict[Future[UnitResult], Unit] = {}
    while True:
        while len(running) < workers.slots and not any(u.alone for u in running.values()):
            unit = next_unit(bool(running))
            if unit is None:
                break
            running[workers.submit(grade_unit, unit)] = unit
        if not running:
            return
        finished = wait(running, return_when=FIRST_COMPLETED).done
        for future in sorted(finished, key=lambda f: running[f].key):
            done(running.pop(future), _outcome(future))


def refusal(workers: Workers) -> str:
    """Say why the workers should not run other people's code; "" if they may."""
    try:
        return str(workers.submit(isolation_problem).result())
    except BrokenExecutor as error:
        raise GraderError(f"no worker could be started ({error})") from None


def _outcome(future: Future[UnitResult]) -> UnitResult:
    try:
        return future.result()
    except BrokenExecutor:
        return UnitResult(None, "its worker died while grading it", died=True)
    except Exception as error:  # Dask's KilledWorker, or a result that can't be unpickled
        return UnitResult(None, f"its worker failed ({type(error).__name__})", died=True)


class LocalWorkers:
    def __init__(self, workers: int) -> None:
        self.slots = workers
        self._tasks: dict[ProcessPoolExecutor, Future[Any]] = {}  # what each worker runs, or ran

    def submit(self, task: Callable[..., Any], *arguments: Any) -> Future[Any]:
        """Have a free worker run a function; a dead worker is replaced."""
        free = (worker for worker, last in self._tasks.items() if last.done())
        worker = next(free, None) or _one_process()
        try:
            future = worker.submit(task, *arguments)
        except BrokenExecutor:  # it died, in its last unit or since
            worker.shutdown(wait=False)
            self._tasks.pop(worker, None)
            worker = _one_process()
            future = worker.submit(task, *arguments)
        self._tasks[worker] = future
        return future

    def close(self, *, now: bool) -> None:
        for worker in self._tasks:
            if now:
                for process in list((worker._processes or {}).values()):
                    process.kill()
            worker.shutdown(wait=True, cancel_futures=True)


class DaskWorkers:
    """The workers of a Dask cluster."""

    def __init__(self, where: str) -> None:
        try:
            import distributed  # noqa: PLC0415  (an extra)
        except ImportError:
            raise InputError(
                "--dask needs the extra `cluster`; install it: pip install --editable '.[cluster]'"
            ) from None
        untyped: Any = distributed
        scheduler = {"scheduler_file": where} if Path(where).is_file() else {"address": where}
        try:
            self._client = untyped.Client(**scheduler, timeout=CONNECT_LIMIT)
        except (OSError, ValueError, TimeoutError) as error:
            raise InputError(
                f"--dask {where}: no scheduler there ({error}); expected an address such as "
                "tcp://host:8786, or the file that `dask scheduler --scheduler-file FILE` writes"
            ) from None
        self._executor: Executor = self._client.get_executor(retries=DASK_RETRIES, pure=False)

    @property
    def slots(self) -> int:
        """One unit a worker thread of the cluster; at least one, since workers may join later."""
        threads: dict[str, int] = self._client.nthreads()
        return max(1, sum(threads.values()))

    def submit(self, task: Callable[..., Any], *arguments: Any) -> Future[Any]:
        """Let the scheduler choose a worker."""
        future: Future[Any] = self._executor.submit(task, *arguments)
        return future

    def close(self, *, now: bool) -> None:
        """Disconnect from the cluster; it is not ours to shut down."""
        self._executor.shutdown(wait=not now)
        self._client.close()


Workers = LocalWorkers | DaskWorkers


def _one_process() -> ProcessPoolExecutor:
    return ProcessPoolExecutor(1, own_processes(), _begin_worker, max_tasks_per_child=MAX_UNITS)


def _begin_worker() -> None:
    """End the worker with its parent, but leave Ctrl-C to the parent."""
    os.setpgid(0, 0)
    end_with_parent()
