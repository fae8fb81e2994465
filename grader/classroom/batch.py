"""Grade a class: take the submissions in, grade or judge again, write the results."""

from __future__ import annotations

import contextlib
import fcntl
import os
import shutil
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from grader.classroom.account import Account
from grader.classroom.candidates import Class, enter_candidates, find_class
from grader.classroom.grading_run import PARTS, RECORDINGS, GradingRun
from grader.classroom.options import Options
from grader.classroom.progress import Progress
from grader.classroom.regrade_run import RegradeRun
from grader.classroom.results import Missing, ResultOptions, column_titles, write_results
from grader.classroom.row import GRADED, HELD, StoredResult
from grader.classroom.store import Store
from grader.errors import GraderError, naming_a_full_disk
from grader.link.scratch import sweep

STORE = "store.sqlite"
NO_SPACE = (
    "the disk is full, so the batch has stopped. Free some space where {out} is, and in "
    "{temporary}, and run the same command again: it goes on where it was"
)
UNPACKED = ".unpacked"  # archives, during a run


@dataclass(frozen=True)
class GradedClass:
    """What a batch came to."""

    results: list[StoredResult]
    missing: list[Missing]  # parts of the report that could not be made
    account: Account = field(default_factory=Account)  # of what was handed in


def look_at(submissions: Sequence[Path], options: Options) -> Class:
    """Return who handed in what; nothing is graded, and nothing is written.

    Raises
    ------
    InputError
        The submissions can't be read.
    """
    with tempfile.TemporaryDirectory(prefix="course-") as scratch:
        return find_class(submissions, Path(scratch), options)


def autograde(
    submissions: Sequence[Path],
    out: Path,
    options: Options,
    progress: Progress,
    *,
    regrade: bool = False,
) -> GradedClass:
    """Grade every submission that is new or changed; return all results.

    May be killed at any moment and called again: it continues where it stopped. With `regrade` only
    the stored recordings are judged again, and no student code runs.

    Raises
    ------
    InputError
        The submissions can't be read, or code would run without isolation.
    GraderError
        Another batch works on `out`, or no worker can be started.
    DiskFull
        No space was left; what is graded is stored, and what is written is whole.
    """
    with naming_a_full_disk(NO_SPACE.format(out=out, temporary=tempfile.gettempdir())):
        return _autograde(submissions, out, options, progress, regrade=regrade)


def _autograde(
    submissions: Sequence[Path], out: Path, options: Options, progress: Progress, *, regrade: bool
) -> GradedClass:
    out.mkdir(parents=True, exist_ok=True)
    scratch, parts = out / UNPACKED, out / RECORDINGS / PARTS
    with _locked(out), Store(out / STORE) as store, _emptied(scratch), _emptied(parts):
        sweep()
        store.requeue_running()
        taken_in = enter_candidates(submissions, scratch, store, options, regrade=regrade)
        candidates = taken_in.candidates
        if options.retry_held and not regrade:
            store.retry_held()
        run = RegradeRun if regrade else GradingRun
        try:
            notes = run(store, out, candidates, options, progress).run()
        finally:
            store.requeue_running()
        results = store.results()
        wanted = ResultOptions(
            hide=options.hide,
            notes=[*store.notes(), *notes, *_version_notes(results)],
            sources={
                key: candidate.read_if_possible()
                for key, candidate in candidates.items()
                if not candidate.absent
            },
            workers=options.workers,
            account=taken_in.account,
            students=store.students(),
            roster=options.roster,
            nbgrader=options.nbgrader,
            columns=column_titles(options.columns),
        )
        missing = write_results(results, out, wanted).missing
        return GradedClass(results, missing, taken_in.account)


@contextlib.contextmanager
def _locked(out: Path) -> Iterator[None]:
    """Lock the folder against other batches; the lock ends with the process at the latest."""
    fd = os.open(out / ".lock", os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o644)
    try:
        fcntl.flock(fd, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        os.close(fd)
        raise GraderError(f"{out}: another `course autograde` is using it") from None
    try:
        yield
    finally:
        os.close(fd)


@contextlib.contextmanager
def _emptied(folder: Path) -> Iterator[None]:
    """Empty the folder of what a killed run left behind, and remove it at the end."""
    shutil.rmtree(folder, ignore_errors=True)
    try:
        yield
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _version_notes(results: Sequence[StoredResult]) -> list[str]:
    """Say so if workers with different versions graded parts of the class."""
    seen = {
        tuple(sorted(result.grading["versions"].items()))
        for result in results
        if result.grading is not None and result.state in (GRADED, HELD)
    }
    if len(seen) < 2:
        return []
    names = {name for versions in seen for name, _ in versions}
    differ = sorted(n for n in names if len({dict(v).get(n, "none") for v in seen}) > 1)
    return [f"The class was graded with different versions of {', '.join(differ)}."]
