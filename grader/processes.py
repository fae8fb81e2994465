"""Processes of the grader's own, which work beside this one and end with it."""

from __future__ import annotations

import contextlib
import multiprocessing
import multiprocessing.connection
import os
import threading
from multiprocessing.context import SpawnContext


def own_processes() -> SpawnContext:
    """Return how to start processes that import nothing from the current folder.

    Theirs is `python -c`, which looks there first; a student's file may be called `random.py`.
    """
    os.environ["PYTHONSAFEPATH"] = "1"
    return multiprocessing.get_context("spawn")


def end_with_parent() -> None:
    """Let this process end with its parent, whatever ends that."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        threading.Thread(target=_end_with, args=(parent.sentinel,), daemon=True).start()


def _end_with(sentinel: int) -> None:
    with contextlib.suppress(OSError):
        multiprocessing.connection.wait([sentinel])
    os._exit(1)
