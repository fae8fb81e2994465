"""Run units on workers: processes of this machine, or a Dask cluster.

Both are `concurrent.futures` executors, and one loop serves them. A local worker is an executor of
its own with one process, so that a death tells whose unit it was.
"""

from __future__ import annotations

import contextlib
import multiprocessing
import multiprocessing.connection
import os
import threading
from collections.abc import Callable
from concurrent.futures import (
    FIRST_COMPLETED,
    BrokenExecutor,
    Executor,
    Future,
    ProcessPoolExecutor,
    wait,
)
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from grader.classroom.work import Unit, UnitResult, grade_unit, isolation_problem
from grader.errors import GraderError, InputError

DASK_RETRIES = 2
RENEWED = 100  # units after which a local worker is replaced, so that no leak adds up
CONNECT_LIMIT = 20  # [s]


class WorkerDied(Exception):
    """A worker ended in the middle of a unit."""


class Workers(Protocol):
    """Workers."""

    @property
    def slots(self) -> int:
        """How many units may run now."""

    @property
    def local(self) -> bool:
        """They see this machine's folders."""

    def submit(self, task: Callable[..., Any], *arguments: Any) -> Future[Any]:
        """Give a free worker something to do."""

    def close(self, *, now: bool) -> None:
        """Send them home; `now`: in the middle of their work."""


def run(
    workers: Workers,
    next_unit: Callable[[bool], Unit | None],
    done: Callable[[Unit, UnitResult | WorkerDied], None],
) -> None:
    """Run units until there is no more and all are done.

    `next_unit` gets told whether anything is running, and returns None when nothing may start now.
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


def _outcome(future: Future[UnitResult]) -> UnitResult | WorkerDied:
    try:
        return future.result()
    except BrokenExecutor:
        return WorkerDied("its worker died in the middle of it")
    except Exception as error:  # Dask's KilledWorker, or a result that can't be unpickled
        return WorkerDied(f"its worker failed ({type(error).__name__})")


@dataclass
class _Slot:
    """One local worker and what it is at."""

    executor: Executor
    task: Future[Any] | None = None
    begun: int = 0  # units

    @property
    def free(self) -> bool:
        return self.task is None or self.task.done()

    @property
    def broken(self) -> bool:
        return (
            self.task is not None
            and self.task.done()
            and not self.task.cancelled()
            and isinstance(self.task.exception(), BrokenExecutor)
        )


class LocalWorkers:
    """Worker processes of this machine."""

    local = True

    def __init__(self, workers: int) -> None:
        self.slots = workers
        self._slots: list[_Slot] = []

    def submit(self, task: Callable[..., Any], *arguments: Any) -> Future[Any]:
        """Give a free worker something to do; a dead one is replaced."""
        slot = next((slot for slot in self._slots if slot.free), None)
        if slot is None:
            slot = _Slot(_one_process())
            self._slots.append(slot)
        elif slot.broken or slot.begun >= RENEWED:
            slot.executor.shutdown(wait=False)
            slot.executor, slot.begun = _one_process(), 0
        slot.begun += 1
        try:
            slot.task = slot.executor.submit(task, *arguments)
        except BrokenExecutor:  # it died between two units
            slot.executor = _one_process()
            slot.task = slot.executor.submit(task, *arguments)
        return slot.task

    def close(self, *, now: bool) -> None:
        """Send the workers home."""
        for slot in self._slots:
            if now and isinstance(slot.executor, ProcessPoolExecutor):
                for process in list((slot.executor._processes or {}).values()):
                    process.kill()
            slot.executor.shutdown(wait=True, cancel_futures=True)


class DaskWorkers:
    """The workers of a Dask cluster."""

    local = False

    def __init__(self, where: str) -> None:
        try:
            import distributed  # noqa: PLC0415  (an extra)
        except ImportError:
            raise InputError(
                "--dask needs the extra `cluster`; install it: pip install "
                "'rclpy-agents-course[cluster]'"
            ) from None
        untyped: Any = distributed
        scheduler = {"scheduler_file": where} if Path(where).is_file() else {"address": where}
        try:
            self._client = untyped.Client(**scheduler, timeout=CONNECT_LIMIT)
        except (OSError, ValueError, TimeoutError) as error:
            raise InputError(
                f"--dask {where}: no scheduler there ({error}); expected an address such as "
                "tcp://host:8786, or the file of `dask scheduler --scheduler-file FILE`"
            ) from None
        self._executor: Executor = self._client.get_executor(retries=DASK_RETRIES, pure=False)

    @property
    def slots(self) -> int:
        """As many units as the cluster has workers' threads, at least one: more may join."""
        threads: dict[str, int] = self._client.nthreads()
        return max(1, sum(threads.values()))

    def submit(self, task: Callable[..., Any], *arguments: Any) -> Future[Any]:
        """Let the scheduler choose a worker."""
        future: Future[Any] = self._executor.submit(task, *arguments)
        return future

    def close(self, *, now: bool) -> None:
        """Leave the cluster, which is not ours to end."""
        self._executor.shutdown(wait=not now)
        self._client.close()


def _one_process() -> ProcessPoolExecutor:
    return ProcessPoolExecutor(
        1, mp_context=multiprocessing.get_context("spawn"), initializer=_begin_worker
    )


def _begin_worker() -> None:
    """Let the worker end with its parent, but not with a Ctrl-C that is the parent's to handle."""
    os.setpgid(0, 0)
    parent = multiprocessing.parent_process()
    if parent is not None:
        threading.Thread(target=_end_with, args=(parent.sentinel,), daemon=True).start()


def _end_with(sentinel: int) -> None:
    with contextlib.suppress(OSError):
        multiprocessing.connection.wait([sentinel])
    os._exit(1)
