"""Who handed in what: find every student's files, and give an account of them."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from grader.classroom.account import Account, Fate, Line
from grader.classroom.intake.exercise_files import Found, find_files, find_sole, left_over
from grader.classroom.intake.handed_in import WORK, HandedIn, Student
from grader.classroom.intake.skeletons import is_handed_out
from grader.classroom.intake.students import Intake, take_in
from grader.classroom.intake.whose import NOTHING_KNOWN, Known
from grader.classroom.options import Options
from grader.classroom.queue.candidate import Candidate
from grader.classroom.queue.conditions import fingerprint
from grader.classroom.queue.store import Key
from grader.course.exercises import Exercise, all_exercises, find_exercise
from grader.course.students import student_key
from grader.errors import InputError
from grader.lms.book import Handed, StudentRow
from grader.lms.clean import one_line
from grader.lms.people import NO_PERSON
from grader.lms.platform import Entry
from grader.lms.told import EXPECTED, moment

OTHER_CLASS = "nobody in it handed in anything here: is it this class's roster?"
ANONYMOUS = (
    "the download is anonymous, and no gradebook has its ids; end that in the assignment's "
    "settings and download it again, or say of each whose it is: course marks assign"
)
NOBODY_SO = "nobody in the roster is called so or has this id"
CONTRARY = (
    "another work of that name came in another download, and this one does not count; "
    "was one of them handed in to the wrong assignment?"
)
SUSPECT = "may be an exercise that is missing; no exercise has a file of this name"
LINKS = "links, which are not followed"
SKELETON = "still as it was handed out, so it was not handed in"
ACCEPTED = "accepted by a person"
NO_TIME = "{!r}, when it was handed in, is no time, and counts as none; {}"
ANOTHER = (
    "{}'s number is {}, and that of the earlier work is {}: a second student of this name? If "
    "it is the same one: course marks assign FOLDER {!r} {!r}; if not, give the grading worksheet "
    "as --roster"
)


@dataclass(frozen=True)
class Class:
    """Everybody's work, and the account of it."""

    candidates: dict[Key, Candidate]
    account: Account
    students: tuple[StudentRow, ...] = ()
    said: str = ""  # of earlier results
    kept: frozenset[Key] = frozenset()  # graded before, and not in these downloads


def find_class(
    submissions: Sequence[Path], scratch: Path, options: Options, known: Known = NOTHING_KNOWN
) -> Class:
    """Find everybody's files of every exercise that counts.

    Raises InputError: nobody handed in a file of any exercise, or `submissions` can't be read.
    """
    intake = take_in(submissions, scratch, options.roster, known)
    everything = {exercise.slug: exercise for exercise in all_exercises()}
    found = {
        student.id: {
            slug: find_files(
                student, exercise.files, known.accepted.get((student.id, slug), ""), ACCEPTED
            )
            for slug, exercise in everything.items()
        }
        for student in intake.students
    }
    exercises = _wanted(everything, found, options, submissions, intake.students)
    if len(exercises) == 1:
        ((slug, exercise),) = exercises.items()
        for student in intake.students:
            mine = found[student.id]
            if not any(each.files for each in mine.values()) and student.files:
                mine[slug] = find_sole(student, exercise.files)
    leaders = _leaders(found)
    conditions = {slug: fingerprint(exercise) for slug, exercise in exercises.items()}
    candidates = {}
    for student in intake.students:
        mine = found[student.id]
        nothing = _handed_in_nothing(student, mine.values())
        for slug, exercise in exercises.items():
            each, leader = mine[slug], leaders.get((student.id, slug), "")
            candidates[student.id, slug] = Candidate(
                student.id,
                exercise,
                each.files,
                each.every,
                _readable(student, each),
                student_key(options.secret, leader or student.id, slug) if options.secret else None,
                conditions[slug],
                student.whose or _another(student, slug, each, known) or each.problem,
                absent=nothing and not each.files,
                leader=leader,
            )
    odd: list[Line] = []  # times
    students = tuple(
        _row(student, [(slug, found[student.id][slug].entry) for slug in exercises], options, known,
             odd) for student in intake.students
    )  # fmt: skip
    account = _account(intake, found, exercises, options)
    return Class(candidates, Account((*account.lines, *odd)), students)


def _readable(student: Student, found: Found) -> dict[str, Path]:
    """Return what a person may read: the student's Python by its place, or what may be it."""
    rest = {file.name: file.path for file in student.files if file.name.lower().endswith(WORK)}
    return {**found.files, **found.python} or rest


def _leaders(found: Mapping[str, Mapping[str, Found]]) -> dict[Key, str]:
    """Return for each member of a group who is graded for all who handed in the same files."""
    first: dict[object, str] = {}
    leaders = {}
    for student, mine in sorted(found.items()):
        for slug, each in mine.items():
            same = (slug, tuple((file.entry.path, file.name) for file in each.used))
            if each.used and first.setdefault(same, student) != student:
                leaders[student, slug] = first[same]
    return leaders


def _another(student: Student, slug: str, found: Found, known: Known) -> str:
    """Say why work may be a namesake's: the platform has another number for it here."""
    row, entry = known.rows.get(student.id), found.entry
    if student.person is not None or row is None or entry is None or slug not in row.handed:
        return ""
    before = row.handed[slug]
    platform = entry.who.platform
    if not platform.per_assignment or before.system != platform.word or entry.word in row.seen:
        return ""
    said = known.assigned.get(entry.word) or known.assigned.get(entry.path.name)
    ids = entry.who.id, before.id
    return "" if said or not before.id else ANOTHER.format(platform.name, *ids, entry.path.name,
                                                           student.id)  # fmt: skip


def _wanted(
    everything: Mapping[str, Exercise],
    found: Mapping[str, Mapping[str, Found]],
    options: Options,
    submissions: Sequence[Path],
    students: Sequence[Student],
) -> dict[str, Exercise]:
    """Return the exercises that are graded: those named, or those that somebody handed in."""
    if options.exercises:
        named = [find_exercise(name) for name in options.exercises]
        return {exercise.slug: exercise for exercise in named}
    handed_in = {slug for mine in found.values() for slug, each in mine.items() if each.files}
    if not handed_in:
        first = min(students, key=lambda each: (not each.problem, not each.files))
        problem = next(iter(found[first.id].values())).problem
        where = ", ".join(map(str, submissions))
        raise InputError(
            f"{where}: none of {len(students)} students has a file of any exercise; "
            f"{first.id}: {problem}"
        )
    return {slug: exercise for slug, exercise in everything.items() if slug in handed_in}


def _handed_in_nothing(student: Student, found: Collection[Found]) -> bool:
    """Return whether what a student has no file of was not handed in, as far as can be told.

    It was perhaps, if a part can't be read, or if something is there and none of it has the name of
    an exercise's file. Then a person has to look.
    """
    if student.problem or student.whose:
        return False
    if any(each.files for each in found):
        return True
    if any(each.untouched for each in found):  # the skeletons, and nothing else that may be work
        return all(is_handed_out(file.path) for file in left_over(student, ()))
    return not student.files and not student.links


# --- the account ---------------------------------------------------------------------------------


def _account(
    intake: Intake, found: Mapping[str, Mapping[str, Found]], wanted: Collection[str],
    options: Options,
) -> Account:  # fmt: skip
    lines = []
    unknown = options.roster.people and not any(s.person and s.who for s in intake.students)
    if unknown:
        sheets = ", ".join(str(sheet.file) for sheet in options.roster.sheets)
        anonymous = all(who.anonymous and not who.id
                        for student in intake.students for who in student.who)  # fmt: skip
        reason = ANONYMOUS if anonymous else OTHER_CLASS
        lines.append(Line(Fate.UNKNOWN, entry=sheets, reason=reason, fault=True))
    for student in intake.students:
        lines += _student_lines(student, _fates(student, found[student.id], wanted))
        if options.roster.people and student.person is None:
            reason, held = student.whose or NOBODY_SO, bool(student.whose)
            lines.append(Line(Fate.STRANGER, student=student.id, reason=reason,
                              fault=not unknown and not held, held=held))  # fmt: skip
    for each in intake.set_aside:
        state = Fate.UNKNOWN if each.fault else Fate.LEFT_OUT
        lines.append(Line(state, entry=each.name, reason=each.reason, fault=each.fault))
    return Account(tuple(lines))


def _student_lines(student: Student, fates: Mapping[HandedIn, Line]) -> list[Line]:
    """Return a line for each of a student's files; `fates` says what became of some."""
    lines = [
        replace(
            fates.get(file, Line(Fate.EXTRA)),
            entry=file.entry.path.name, file=file.name, student=student.id,
        )
        for file in student.files
    ]  # fmt: skip
    line = partial(
        Line, entry="; ".join(each.path.name for _, each in student.entries), student=student.id
    )
    if student.problem:  # the student is held for it
        lines.append(line(Fate.UNREADABLE, reason=student.problem, held=True))
    elif not student.files and student.links:
        lines.append(line(Fate.UNREADABLE, reason=LINKS, held=True))
    elif not student.files:
        lines.append(line(Fate.NOTHING))
    return lines


def _fates(
    student: Student, found: Mapping[str, Found], wanted: Collection[str]
) -> dict[HandedIn, Line]:
    fates: dict[HandedIn, Line] = {}
    contrary = {file for each in found.values() for file in each.contrary}
    for slug, each in found.items():
        for file in each.older:
            is_other = file in contrary
            reason = CONTRARY if is_other else "a newer one counts"
            fates[file] = Line(Fate.OLDER, exercise=slug, reason=reason, fault=is_other)
    for slug, each in sorted(found.items(), key=lambda pair: pair[0] in wanted):
        state = Fate.GRADED if slug in wanted else Fate.OTHER
        fates |= {file: Line(state, exercise=slug, reason=each.why) for file in each.used}
        for file in each.untouched:
            fates.setdefault(file, Line(Fate.LEFT_OUT, exercise=slug, reason=SKELETON))
        for file in each.beside.values():
            fates.setdefault(
                file, Line(Fate.EXTRA, exercise=slug, reason=f"comes along with {slug}")
            )
    held = not student.problem and not any(each.used for each in found.values())
    if not held and any(not found[slug].files for slug in wanted):  # else the unit itself says it
        known = [f for f in student.files if f in fates and fates[f].state != Fate.EXTRA]
        known += [file for each in found.values() for file in each.needed]
        line = Line(Fate.UNKNOWN, reason=SUSPECT, fault=True)
        fates |= {file: line for file in left_over(student, known) if not is_handed_out(file.path)}
    return fates


def _row(
    student: Student, entries: Iterable[tuple[str, Entry | None]], options: Options, known: Known,
    odd: list[Line],
) -> StudentRow:  # fmt: skip
    handed = {}
    for slug, entry in entries:
        if entry is not None:
            who = entry.who
            told, more = who.platform.times(options.roster, student.person, entry)
            time, more = (_time(each, student, slug, odd) for each in (entry.time or told, more))
            handed[slug] = Handed(
                who.platform.word, who.name, who.id, who.email, entry.late, time, more, entry.upload
            )
    seen = {
        each.word
        for _, each in student.entries
        if not {each.word, each.path.name} & known.assigned.keys()
    }
    person, unsure = student.person or NO_PERSON, bool(student.whose)
    return StudentRow(student.id, person, handed, tuple(sorted(seen)), unsure)


def _time(told: str, student: Student, slug: str, odd: list[Line]) -> str:
    """Return a time as a platform tells it; "" if it is none, and then a line says whose."""
    if not told or moment(told):
        return told
    reason = NO_TIME.format(one_line(told, 60), EXPECTED)
    odd.append(Line(Fate.UNKNOWN, student=student.id, exercise=slug, reason=reason, fault=True))
    return ""
