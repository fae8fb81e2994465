"""Who handed in what: find every student's files and put into the queue what is new or changed."""

from __future__ import annotations

import contextlib
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from grader.classroom.account import (
    CONTRARY,
    EXTRA,
    GRADED,
    OLDER,
    OTHER,
    STRANGER,
    SUSPECT,
    UNKNOWN,
    Account,
    Line,
    set_aside_lines,
    student_lines,
)  # fmt: skip
from grader.classroom.conditions import HASHED, fingerprint, submission_hash
from grader.classroom.intake.exercise_files import Found, find_files, left_over
from grader.classroom.intake.handed_in import Student
from grader.classroom.intake.students import Intake, take_in
from grader.classroom.options import Options
from grader.classroom.row import ABSENT
from grader.classroom.store import Key, Store
from grader.course.beside import MAX_BYTES
from grader.course.exercises import Exercise, all_exercises, find_exercise
from grader.course.students import Seed, student_key
from grader.course.submission import read_regular_file
from grader.errors import InputError
from grader.lms.book import Handed, StudentRow, named
from grader.lms.people import NO_PERSON

MOST_NAMED = 5  # students in a sentence
OTHER_CLASS = (
    "nobody in it handed in anything here: is it this class's roster, and exported in English?"
)


@dataclass(frozen=True)
class Candidate:
    """One student's files for one exercise, where they lie."""

    student: str
    exercise: Exercise
    found: Found
    seed: Seed | None
    conditions: str  # fingerprint of the grader that would judge them
    absent: bool = False  # nothing was handed in for this exercise

    def read(self) -> tuple[dict[str, bytes], str]:
        """Return the files' contents by name, and why nothing can be graded.

        The reason is "" if it can be, or if nothing was handed in.
        """
        try:
            files = {name: read_regular_file(path) for name, path in self.found.files.items()}
            more = self.found.every.items()
            files |= {n: read_regular_file(path, MAX_BYTES) for n, path in more if n not in files}
        except OSError as error:
            name = Path(str(error.filename)).name if error.filename else "a file"
            return {}, f"{name} can't be read ({error.strerror})"
        return files, "" if self.absent else self.found.problem

    def texts(self) -> dict[str, bytes]:
        """Return the student's Python, by its place; what can't be read is left out."""
        found = {}
        for name, path in self.found.python.items():
            with contextlib.suppress(OSError):
                found[name] = read_regular_file(path)
        return found

    def input_hash(self, files: Mapping[str, bytes], options: Options) -> str:
        """Return a hash of all that the grading of these files depends on."""
        submitted = submission_hash(
            self.exercise, files, seed=self.seed, field=options.field, tier=options.tier
        )
        return f"{submitted}{self.conditions}"


@dataclass(frozen=True)
class Class:
    """Everybody's work, and the account of it."""

    candidates: dict[Key, Candidate]
    account: Account
    students: tuple[StudentRow, ...] = ()
    gone: str = ""  # whose earlier results were dropped


def enter_candidates(
    submissions: Sequence[Path], scratch: Path, store: Store, options: Options, *, regrade: bool
) -> Class:
    """Find everybody's files and queue what is new or changed.

    A changed grader counts as a change too, except where recordings are to be judged again.

    Raises InputError: nobody handed in a file of any exercise, or `submissions` can't be read.
    """
    found = find_class(submissions, scratch, options)
    slugs = {slug for _, slug in found.candidates}
    stored = [r for r in store.results() if not r.canary and r.exercise in slugs]
    before = {r.student for r in stored if r.state != ABSENT}
    here = {student for (student, _), each in found.candidates.items() if not each.absent}
    if before and not before & here:
        raise InputError(
            f"expected the class that was graded here: of its {len(before)} students "
            f"({_some(before)}) nobody is in {', '.join(map(str, submissions))} "
            f"({_some(here)}); give another --out for another class"
        )
    for key, candidate in found.candidates.items():
        files, problem = candidate.read()
        store.enter(
            key,
            candidate.input_hash(files, options),
            problem=problem,
            absent=candidate.absent,
            compared=HASHED if regrade else None,
        )
    said = ""
    gone = {r.student for r in stored} - {student for student, _ in found.candidates}
    if store.keep_only(found.candidates, slugs):
        said = (
            "Earlier results were dropped, because their students are no longer there: "
            f"{_some(gone)}. A run with all downloads of the class grades them again."
        )
        store.note(said)
    store.know(found.students)
    return replace(found, gone=said)


def _some(students: Collection[str]) -> str:
    return named(sorted(students), MOST_NAMED)


def find_class(submissions: Sequence[Path], scratch: Path, options: Options) -> Class:
    """Find everybody's files of every exercise that counts.

    Raises InputError: nobody handed in a file of any exercise, or `submissions` can't be read.
    """
    intake = take_in(submissions, scratch, options.roster)
    everything = {exercise.slug: exercise for exercise in all_exercises()}
    found = {
        (student.id, slug): find_files(student, exercise.files)
        for student in intake.students
        for slug, exercise in everything.items()
    }
    exercises = _wanted(everything, found, options, submissions, intake.students)
    conditions = {slug: fingerprint(exercise) for slug, exercise in exercises.items()}
    candidates = {}
    for student in intake.students:
        nothing = _handed_in_nothing(student, [found[student.id, slug] for slug in everything])
        for slug, exercise in exercises.items():
            each = found[student.id, slug]
            candidates[student.id, slug] = Candidate(
                student.id,
                exercise,
                each,
                None if options.secret is None else student_key(options.secret, student.id, slug),
                conditions[slug],
                absent=nothing and not each.files,
            )
    account = _account(intake, found, list(exercises), options)
    students = tuple(_row(student, found, list(exercises)) for student in intake.students)
    return Class(candidates, account, students)


def _wanted(
    everything: Mapping[str, Exercise],
    found: Mapping[Key, Found],
    options: Options,
    submissions: Sequence[Path],
    students: Sequence[Student],
) -> dict[str, Exercise]:
    """Return the exercises that are graded: those named, or those that somebody handed in."""
    if options.exercises:
        named = [find_exercise(name) for name in options.exercises]
        return {exercise.slug: exercise for exercise in named}
    handed_in = {slug for (_, slug), each in found.items() if each.files}
    if not handed_in:
        problem = next((each.problem for each in found.values() if each.problem), "")
        where = ", ".join(map(str, submissions))
        raise InputError(
            f"{where}: none of {len(students)} students has a file of any exercise; "
            f"{students[0].id}: {problem}"
        )
    return {slug: exercise for slug, exercise in everything.items() if slug in handed_in}


def _handed_in_nothing(student: Student, found: Sequence[Found]) -> bool:
    """Return whether what a student has no file of was not handed in, as far as can be told.

    It was perhaps, if a part can't be read, or if something is there and none of it has the name of
    an exercise's file. Then a person has to look.
    """
    if student.problem:
        return False
    if any(each.files for each in found):
        return True
    return not student.files and not student.links


# --- the account ---------------------------------------------------------------------------------


def _account(
    intake: Intake, found: Mapping[Key, Found], wanted: Sequence[str], options: Options
) -> Account:
    lines = []
    slugs = list(dict.fromkeys(slug for _, slug in found))
    unknown = options.roster.people and not any(s.person and s.who for s in intake.students)
    if unknown:
        sheets = ", ".join(str(sheet.file) for sheet in options.roster.sheets)
        lines.append(Line(UNKNOWN, entry=sheets, reason=OTHER_CLASS, fault=True))
    for student in intake.students:
        mine = {slug: found[student.id, slug] for slug in slugs}
        lines += student_lines(student, _fates(student, mine, wanted))
        if options.roster.people and student.person is None:
            why = options.roster.why_not(student.who[0].name if student.who else student.id)
            lines.append(Line(STRANGER, student=student.id, reason=why, fault=not unknown))
    return Account((*lines, *set_aside_lines(intake.set_aside)))


def _fates(student: Student, found: Mapping[str, Found], wanted: Sequence[str]) -> dict[int, Line]:
    """Return what became of a student's files."""
    fates: dict[int, Line] = {}
    contrary = {id(file) for each in found.values() for file in each.contrary}
    for slug, each in found.items():
        for file in each.older:
            is_other = id(file) in contrary
            reason = CONTRARY if is_other else "a newer one counts"
            fates[id(file)] = Line(OLDER, exercise=slug, reason=reason, fault=is_other)
    for slug, each in sorted(found.items(), key=lambda pair: pair[0] in wanted):
        state = GRADED if slug in wanted else OTHER
        fates |= {id(file): Line(state, exercise=slug) for file in each.used}
        for file in each.beside.values():
            fates.setdefault(
                id(file), Line(EXTRA, exercise=slug, reason=f"comes along with {slug}")
            )
    held = not student.problem and not any(each.used for each in found.values())
    if not held and any(not found[slug].files for slug in wanted):  # else the unit itself says it
        known = [f for f in student.files if id(f) in fates and fates[id(f)].state != EXTRA]
        known += [file for each in found.values() for file in each.needed]
        line = Line(UNKNOWN, reason=SUSPECT, fault=True)
        fates |= {id(file): line for file in left_over(student, known)}
    return fates


def _row(student: Student, found: Mapping[Key, Found], wanted: Sequence[str]) -> StudentRow:
    handed = {}
    for slug in wanted:
        entry = found[student.id, slug].entry
        if entry is not None:
            handed[slug] = Handed(
                entry.who.system, entry.who.name, entry.who.id, entry.who.email, entry.late,
                entry.time,
            )  # fmt: skip
    return StudentRow(student.id, student.person or NO_PERSON, handed)
