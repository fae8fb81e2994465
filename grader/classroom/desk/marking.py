"""Change the marks of a graded class: find who and what is meant, log it, write the results anew.

Everything comes from the store: no recording is read but for replays, and no student's code runs.
"""

from __future__ import annotations

import contextlib
import hashlib
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import msgspec

from grader.classroom.amendments.apply import amended, version_of
from grader.classroom.amendments.change import Accept, Assign, Change, Undo, Whom
from grader.classroom.amendments.log import Entry, active, undone_by
from grader.classroom.amendments.marks import checks_of, points_of, state_of, task_of, tasks_of
from grader.classroom.amendments.people import nearest, the_student
from grader.classroom.folder import UNWRITTEN, locked, opened, write_class
from grader.classroom.queue.store import Store
from grader.classroom.results.options import OPTIONS, ResultOptions, kept_options
from grader.classroom.row import StoredResult, as_graded
from grader.errors import InputError, naming_a_full_disk
from grader.lms.book import StudentRow, Task

UNFINISHED = ". Not all results were written into the files here: `course marks write {}` does"
NO_SPACE = (
    "the disk is full: what is in the log of marks stays there (`course report {out}` prints it), "
    "but not all results were written. Free some space, and run `course marks write {out}`"
)


@dataclass(frozen=True)
class Marked:
    """What a change came to."""

    entry: Entry | None  # of the log
    shifts: list[str]  # a line for each student whose points change
    lower: int  # students who lose points
    remarks: list[str]  # what a person should know
    missing: list[str]  # parts of the results that could not be written


@contextlib.contextmanager
def marking(out: Path) -> Iterator[Marking]:
    """Open a graded class to change its marks; nobody else may write meanwhile.

    Raises InputError: no class was graded here, or the store is of another version.
    Raises GraderError: somebody else is writing.
    Raises DiskFull: no space was left.
    """
    with opened(out) as store, locked(out), naming_a_full_disk(NO_SPACE.format(out=out)):
        yield Marking(store, out)


@contextlib.contextmanager
def reading(out: Path) -> Iterator[Marking]:
    """Open a graded class, also while it is graded, only to read.

    Raises InputError: no class was graded here, or the store is of another version.
    """
    with opened(out) as store:
        yield Marking(store, out)


class Marking:
    """A graded class whose marks may be changed.

    Where nobody and nothing is called as a person says, InputError names the nearest.
    """

    def __init__(self, store: Store, out: Path) -> None:
        self.store = store
        self.out = out
        self.say: Callable[[str], object] = str  # it is told how far the writing is
        self.options: ResultOptions = kept_options(store.kept(OPTIONS), store.students())

    @cached_property
    def results(self) -> list[StoredResult]:
        """All results, as they were graded."""
        return self.store.results()

    @property
    def rows(self) -> Mapping[str, StudentRow]:
        return self.options.students

    @cached_property
    def students(self) -> list[str]:
        return sorted({result.student for result in self.results})

    @property
    def sections(self) -> list[str]:
        return sorted({row.person.section for row in self.rows.values()} - {""})

    @property
    def entries(self) -> list[Entry]:
        return self.store.entries()

    def revision(self, students: Sequence[str] = ()) -> str:
        """Return what tells these students' marks, or everybody's, from later ones.

        Another entry about them changes it, and so does another grading.
        """
        mine = set(students)
        entries = [
            each for each in self.entries
            if not mine or any(is_about(each, student, self.rows) for student in mine)
        ]  # fmt: skip
        graded = [
            (one.student, one.exercise, one.state, one.finished, one.input_hash)
            for one in self.results
            if not mine or one.student in mine
        ]
        kept = "" if mine else self.store.kept(OPTIONS)
        text = msgspec.json.encode(([entry.number for entry in entries], graded, kept))
        return hashlib.sha256(text).hexdigest()[:32]

    # --- what is told ----------------------------------------------------------------------------

    def summary(self) -> str:
        states = Counter(state_of(result) for result in self.results)
        counts = ", ".join(f"{count} {state}" for state, count in sorted(states.items()))
        text = f"{len(self.students)} students; as graded: {counts}"
        return text + (UNFINISHED.format(self.out) if self.unfinished else "")

    @property
    def unfinished(self) -> bool:
        return bool(self.store.kept(UNWRITTEN))

    def student(self, word: str) -> str:
        return the_student(word, self.students, self.rows)

    def points(self, student: str) -> list[tuple[StoredResult, str, str]]:
        """Return a student's results with the points as graded and as they count."""
        mine = [each for each in self.counting() if each.student == student]
        return [(each, _shown(as_graded(each)), _shown(each)) for each in mine]

    # --- what is meant ---------------------------------------------------------------------------

    def exercise(self, name: str) -> Task:
        """Return the exercise that is meant; "": the only one.

        Raises InputError: there are several, or it is none of this class's.
        """
        tasks = tasks_of(self.results)
        slugs = [task.slug for task in tasks]
        if not name and len(tasks) == 1:
            return tasks[0]
        if not name:
            raise InputError(f"--exercise: expected one of {', '.join(slugs)}")
        for task in tasks:
            if name in (task.slug, str(task.number)):
                return task
        raise nearest(name, slugs, "exercise of this class")

    def any_exercise(self, name: str) -> Task:
        """Return an exercise by name, even if there are no submissions."""
        return task_of(name)

    def whom(
        self, words: Sequence[str], section: str, *, everybody: bool, task: Task | None = None
    ) -> Whom:
        """Return whom a change is about; of students with the submission that it is made for."""
        if bool(words) + bool(section) + everybody != 1:
            raise InputError("expected whom it is about: --student ID, --section NAME or --all")
        if section:
            if section not in self.sections:
                raise nearest(section, self.sections, "section")
            return Whom(section=section)
        found = [the_student(word, self.students, self.rows) for word in words]
        mine = [r for r in self.results if task is not None and r.exercise == task.slug]
        versions = {r.student: version_of(r) for r in mine if r.student in found}
        return Whom(tuple(dict.fromkeys(found)), versions={k: v for k, v in versions.items() if v})

    def check(self, task: Task, name: str, whom: Whom) -> float:
        """Return the points that a check can give."""
        mine = [r for r in self.results if r.exercise == task.slug]
        found = {str(check.get("id")): check for one in mine for check in checks_of(one)}
        if name not in found:
            raise nearest(name, found, f"check of {task.slug}")
        for one in mine:
            if one.student in whom.students and not checks_of(one):
                raise InputError(
                    f"{one.student} has no grading in {task.slug} ({state_of(one)}), so there is "
                    "no check to change; give a score: course marks score"
                )
        return float(found[name].get("max_points") or 0)

    # --- what is done ----------------------------------------------------------------------------

    def add(self, change: Change, who: str, why: str) -> Marked:
        """Log a change, and write all results as they count now."""
        before, done = self._comes_to(change)  # what can't be counted with is not logged
        entry = self.store.log(change, who, why)
        return replace(done, entry=entry, missing=self._written(before)[1])

    def preview(self, change: Change) -> Marked:
        """Return what a change would come to; nothing is written."""
        return self._comes_to(change)[1]

    def _comes_to(self, change: Change) -> tuple[list[StoredResult], Marked]:
        undoing = change.number if isinstance(change, Undo) else 0
        entries = self.store.entries(undoing)  # one that can't be read may be undone
        if undoing:
            _check_undo(undoing, entries)
        before, known = self._amended(entries)
        number = max((entry.number for entry in entries), default=0) + 1
        after, remarks = self._amended([*entries, Entry(number, "", "", change, "")])
        new = [remark for remark in remarks if remark not in known]
        return before, Marked(None, *_shifts(before, after), new, [])

    def assigned(self, word: str, people: Sequence[str]) -> Assign:
        """Return the change by which an entry of a download is these students'."""
        every = sorted({*self.students, *self.rows})
        whom = tuple(dict.fromkeys(the_student(each, every, self.rows) for each in people))
        lines = [each for each in self.options.account.lines if each.entry and word in
                 (each.entry, each.student)]  # fmt: skip
        if not lines and word not in self.rows:
            entries = {each.entry for each in self.options.account.lines if each.entry}
            raise nearest(word, entries, "entry of the downloads")
        was = word if word in self.rows else next((each.student for each in lines), "")
        if was in whom:  # a namesake's number, which is theirs indeed
            return Assign((word,), "", Whom(whom))
        mine = self.rows.get(was)
        if mine is not None and mine.person.name and word == was:
            raise InputError(
                f"{was} is in the roster ({mine.person.key}); expected an entry of a download, "
                "such as intake.csv lists them"
            )
        if mine is None or mine.person.name:  # a name in the download
            return Assign((word,), "", Whom(whom))
        return Assign(mine.seen, was, Whom(whom))

    def accepted(self, student: str, file: str, task: Task) -> Accept:
        """Return the change by which a file counts as an exercise's."""
        files = {each.file for each in self.options.account.lines if each.student == student}
        if file not in files:
            raise nearest(file, files - {""}, f"file of {student}")
        return Accept(task.slug, file, Whom((student,)))

    def write(self) -> Marked:
        return Marked(None, [], 0, [], self._written()[1])

    def counting(self) -> list[StoredResult]:
        """Return the results as they count now."""
        return self._amended(self.entries)[0]

    def _amended(self, entries: Sequence[Entry]) -> tuple[list[StoredResult], list[str]]:
        return amended(self.results, active(entries), self.rows)

    def _written(self, before: Sequence[StoredResult] = ()) -> tuple[list[StoredResult], list[str]]:
        results, written = write_class(self.store, self.out, self.options, before, self.say)
        return results, written.missing


def _shifts(before: Sequence[StoredResult], after: Sequence[StoredResult]) -> tuple[list[str], int]:
    """Return a line for each whose points change, and how many lose some."""
    lines, lower = [], 0
    for old, new in zip(before, after, strict=False):
        was, now = _shown(old), _shown(new)
        if was != now:
            lines.append(f"{new.student}  {new.exercise}  {was} \N{RIGHTWARDS ARROW} {now}")
        had, has = points_of(old), points_of(new)
        lower += had is not None and (has is None or has < had)
    return lines, lower


def _shown(result: StoredResult) -> str:
    points = points_of(result)
    return state_of(result) if points is None else f"{points:g}"


def _check_undo(number: int, entries: Sequence[Entry]) -> None:
    numbers = [entry.number for entry in entries]
    if number not in numbers:
        there = f"1 to {numbers[-1]}" if numbers else "none yet"
        raise InputError(f"the log has no entry {number}; there are: {there}")
    for entry in undone_by(entries):
        if entry[0] == number:
            raise InputError(
                f"entry {number} is undone already, by entry {entry[1]}; to bring it back, "
                f"undo {entry[1]}"
            )


def is_about(entry: Entry, student: str, rows: Mapping[str, StudentRow]) -> bool:
    change = entry.change
    return isinstance(change, Undo) or change.whom.includes(student, rows)
