"""Grade a class: take the submissions in, grade or judge again, write the results."""

import contextlib
import hashlib
import hmac
import json
import shutil
import tempfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from grader.classroom.account import Account
from grader.classroom.amendments.people import the_student
from grader.classroom.folder import STORE, locked, write_class
from grader.classroom.intake.candidates import Class, find_class
from grader.classroom.intake.entering import enter_candidates, known_of
from grader.classroom.intake.whose import NOTHING_KNOWN
from grader.classroom.options import Options
from grader.classroom.progress import Progress
from grader.classroom.queue.grading_run import PARTS, RECORDINGS, GradingRun
from grader.classroom.queue.store import Store
from grader.classroom.results.options import OPTIONS, ResultOptions, column_titles, kept_text
from grader.classroom.results.sources import SOURCES, write_course, write_sources
from grader.classroom.results.write import Written
from grader.classroom.row import StoredResult
from grader.errors import InputError, naming_a_full_disk
from rclpy_virtual_time import sweep

NO_SPACE = (
    "the disk is full, so the batch has stopped. Free some space where {out} is, and in "
    "{temporary}, and run the same command again: it resumes where it left off"
)
SECRET = "secret"  # what the store calls the mark of the class's
UNPACKED = ".unpacked"  # archives, during a run


@dataclass(frozen=True)
class GradedClass:
    """What a batch came to."""

    results: list[StoredResult]
    missing: list[str]  # parts of the results that could not be made
    account: Account = field(default_factory=Account)  # of what was handed in


@contextlib.contextmanager
def looked_at(
    submissions: Sequence[Path], options: Options, out: Path | None = None
) -> Iterator[Class]:
    """Return who handed in what; nothing is graded, and nothing is written.

    Of a class that was graded into `out` it is known who is who.

    Raises InputError: the submissions can't be read.
    """
    known = NOTHING_KNOWN
    if out is not None and (out / STORE).is_file():
        with Store(out / STORE) as store:
            known = known_of(store)
    with tempfile.TemporaryDirectory(prefix="course-") as scratch:
        yield find_class(submissions, Path(scratch), options, known)


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

    Raises InputError: the submissions can't be read, or code would run without isolation.
    Raises GraderError: another batch works on `out`, or no worker can be started.
    Raises DiskFull: no space was left; what is graded is stored, and what is written is whole.
    """
    scratch, parts = out / UNPACKED, out / RECORDINGS / PARTS
    with (
        naming_a_full_disk(NO_SPACE.format(out=out, temporary=tempfile.gettempdir())),
        locked(out),
        Store(out / STORE) as store,
        _emptied(scratch),
        _emptied(parts),
    ):
        sweep()
        store.requeue_running()
        _refuse_another(options, store)
        taken_in = enter_candidates(submissions, scratch, store, options, regrade=regrade)
        if taken_in.said:
            progress.say(taken_in.said)
        only = _students(options.only if regrade else options.again, store, taken_in)
        if options.retry_held and not regrade:
            store.retry_held()
        if not regrade:
            store.again(key for key in taken_in.candidates if key[0] in only)
        writer = _Writer(store, out, options, taken_in, progress.say)
        writer.wanted()
        candidates = {
            key: candidate
            for key, candidate in taken_in.candidates.items()
            if not only or not regrade or key[0] in only
        }
        run = GradingRun(store, out, candidates, options, progress)
        notes: list[str] = []
        try:
            if regrade:
                run.judge_again()
            else:
                notes = run.run()
        except KeyboardInterrupt:
            store.requeue_running()
            progress.say("interrupted: writing what is graded; Ctrl-C again leaves at once")
            writer.write([])
            raise
        finally:
            store.requeue_running()
        results, written = writer.write(notes, over=True)
        return GradedClass(results, written.missing, taken_in.account)


def _refuse_another(options: Options, store: Store) -> None:
    """Refuse what contradicts the last run into this folder.

    Raises InputError: the class has a secret, and this is none or another; or something was hidden
    from students, and nothing is said of that now.
    """
    secret, before = options.secret, store.kept(SECRET)
    # what tells one secret from another and nothing else of it
    mark = hmac.new(secret, b"this class", hashlib.sha256).hexdigest()[:16] if secret else ""
    if before not in ("", mark):
        raise InputError(
            "--secret: expected the file that this class was graded with, in whose worlds all its "
            f"results are, but there is {'another' if secret else 'none'}; for other worlds give "
            "another --out"
        )
    hidden = json.loads(store.kept(OPTIONS) or "{}").get("hide", "nothing")
    if not options.hide and hidden != "nothing":
        raise InputError(
            f"--hide: the last run hid {hidden} from students; give --hide {hidden} again, or "
            "--hide nothing"
        )
    store.keep(SECRET, mark)


def _students(words: Sequence[str], store: Store, taken_in: Class) -> set[str]:
    """Return the students who are meant; none if nobody is named."""
    everybody = sorted({student for student, _ in taken_in.candidates})
    rows = store.students()
    return {the_student(word, everybody, rows) for word in words}


@dataclass(frozen=True)
class _Writer:
    """Writes the results when the batch is over, or was interrupted."""

    store: Store
    out: Path
    options: Options
    taken_in: Class
    say: Callable[[str], object]

    def wanted(self, notes: Sequence[str] = ()) -> ResultOptions:
        """Return how results are written, and keep it: marks change later, also after a kill."""
        titles = json.loads(self.store.kept(OPTIONS) or "{}").get("columns", {})  # of the last run
        wanted = ResultOptions(
            hide=self.options.hide or "nothing",
            notes=[*self.store.notes(), *notes],
            workers=self.options.workers,
            account=self.taken_in.account,
            students=self.store.students(),
            roster=self.options.roster,
            columns=titles | column_titles(self.options.columns),
        )
        self.store.keep(OPTIONS, kept_text(wanted))
        return wanted

    def write(
        self, notes: Sequence[str], *, over: bool = False
    ) -> tuple[list[StoredResult], Written]:
        """Write all results; what was handed in is copied only when all is over."""
        wanted = self.wanted(notes)
        results, written = write_class(self.store, self.out, wanted, say=self.say)
        if over:
            self._write_sources(written)
        return results, written

    def _write_sources(self, written: Written) -> None:
        """Copy everybody's files, a group's once; of who is kept, files are not here."""
        folder, slugs = self.out / SOURCES, set()
        if not self.taken_in.kept:
            shutil.rmtree(folder, ignore_errors=True)
        for (student, slug), candidate in self.taken_in.candidates.items():
            if not candidate.absent and not candidate.leader:
                slugs.add(slug)
                with written.part(f"{SOURCES}/{slug}/{student}"):
                    files, _ = candidate.read()
                    written.files.extend(write_sources(folder, student, slug, files))
        with written.part(SOURCES):
            write_course(folder, slugs)


@contextlib.contextmanager
def _emptied(folder: Path) -> Iterator[None]:
    shutil.rmtree(folder, ignore_errors=True)
    try:
        yield
    finally:
        shutil.rmtree(folder, ignore_errors=True)
