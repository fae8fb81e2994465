"""The folder of a graded class: who may write into it, and its results as they count now."""

import contextlib
import fcntl
import os
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path

from grader.classroom.amendments.apply import amended, published
from grader.classroom.amendments.log import active
from grader.classroom.queue.store import Store
from grader.classroom.results.options import ResultOptions
from grader.classroom.results.write import Written, write_results
from grader.classroom.row import StoredResult
from grader.errors import GraderError, InputError

STORE = "store.sqlite"
# What the store calls it that not all results are written: somebody is at it, was killed, or failed
UNWRITTEN = "unwritten"


@contextlib.contextmanager
def locked(out: Path) -> Iterator[None]:
    """Make and lock the folder against others who write; the lock ends with the process at last.

    Raises GraderError: somebody else has it.
    """
    out.mkdir(parents=True, exist_ok=True)
    fd = os.open(out / ".lock", os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o644)
    try:
        fcntl.flock(fd, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        os.close(fd)
        raise GraderError(
            f"{out}: another `course autograde` or `course marks` is using it; wait until it is "
            "over, or stop it (it goes on later)"
        ) from None
    try:
        yield
    finally:
        os.close(fd)


@contextlib.contextmanager
def opened(out: Path) -> Iterator[Store]:
    """Open the store of a class that was graded.

    Raises InputError: there is none here.
    """
    if not (out / STORE).is_file():
        raise InputError(
            f"{out}: expected the folder that `course autograde … --out FOLDER` has written, with "
            f"a file {STORE} in it"
        )
    with Store(out / STORE) as store:
        yield store


def write_class(
    store: Store, out: Path, options: ResultOptions, before: Sequence[StoredResult] = (),
    say: Callable[[str], object] = str,
) -> tuple[list[StoredResult], Written]:  # fmt: skip
    """Write all results as they count now; return them, and what was written.

    Pages of students whose results are as `before`, when all were written, stay as they are. `say`
    is told how far it is.
    """
    log = store.entries()
    counting = active(log)
    results, remarks = amended(store.results(), counting, options.students)
    wanted = replace(
        options,
        notes=[*options.notes, *(f"{remark}." for remark in remarks)],
        log=log,
        published=published(counting, results, options.students),
    )
    old = {} if store.kept(UNWRITTEN) else {result.key: result for result in before}
    new = {result.student for result in results if result != old.get(result.key)}
    store.keep(UNWRITTEN, "yes")
    written = write_results(results, out, wanted, {student for student, _ in old} - new, say)
    store.keep(UNWRITTEN, "yes" if written.missing else "")
    return results, written
