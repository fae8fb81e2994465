"""From downloads to students: read them, unpack archives, bring together what is one's."""

from __future__ import annotations

import os
import stat
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from grader.classroom.intake import notebooks
from grader.classroom.intake.handed_in import HandedIn, Student
from grader.course.beside import MADE
from grader.errors import InputError, is_disk_full
from grader.link.cell import Broken, Refused
from grader.lms import PLATFORMS
from grader.lms.gradescope import METADATA
from grader.lms.names import may_enter, student_id, unique
from grader.lms.people import NOBODY, Roster, folded
from grader.lms.platform import Entry, Read, SetAside, Who
from grader.lms.unpack import (
    ARCHIVES,
    MAX_DEPTH,
    is_archive,
    is_unread_archive,
    unpack,
    unpack_class,
)
from grader.lms.unpack import (
    LINK as NO_LINK,
)

MAX_LISTED = 20_000  # files of a student's folder that are listed
MAX_NOTEBOOKS = 50  # of a student that are opened
LINK = "a link, which is not followed; expected a folder or an archive"
CLASS = "the work of several students, not of one; name it itself on the command line"
UNREAD = f"an archive that is not read; ask for one of {', '.join(ARCHIVES)}"

Key = tuple[object, ...]  # what makes two entries one student's


@dataclass(frozen=True)
class Intake:
    """A class as it was handed in."""

    students: list[Student]  # by id; with a roster everybody in it
    set_aside: list[SetAside]  # what is in the downloads and nobody's work


def take_in(sources: Sequence[Path], scratch: Path, roster: Roster = NOBODY) -> Intake:
    """Return the students whose work lies in `sources`: folders, or a platform's archives.

    Archives are unpacked below `scratch`; a folder of a source that holds it is nobody's. Everybody
    in the roster is a student.

    Raises InputError: a source can't be read, or there is nothing in them.
    """
    set_aside: list[SetAside] = []
    read: list[tuple[int, Entry]] = []
    for number, source in enumerate(sources):
        folder = _opened(source, scratch / ".downloads" / str(number), set_aside)
        found = _entries(folder, roster, scratch)
        read += [(number, entry) for entry in found.entries]
        set_aside += found.set_aside
    if not read and not roster.people:
        raise InputError(_nothing(sources, set_aside))
    students = _named(_students(read, roster), roster)
    for student in students:
        _fill(student, scratch / student.id, set_aside)
    return Intake(sorted(students, key=lambda student: student.id), set_aside)


def take_in_one(folder: Path, scratch: Path) -> Student:
    """Return the student whose work, and nobody else's, lies in a folder."""
    student = Student("submission", entries=[(0, Entry(folder, Who("submission", "folder")))])
    _fill(student, scratch, [])
    return student


def _opened(source: Path, room: Path, set_aside: list[SetAside]) -> Path:
    """Return the folder with the entries of a download; an archive is unpacked first."""
    if source.is_dir():
        return source
    if not os.path.lexists(source):
        raise InputError(f"{source}: expected what the class has handed in; nothing is there")
    if not source.is_file() or not is_archive(source.name):
        raise InputError(
            f"{source}: expected a folder with a folder or an archive per student, or the archive "
            f"of a learning platform ({', '.join(ARCHIVES)})"
        )
    try:
        odd = unpack_class(source, room)
    except Broken as error:
        raise InputError(f"{source}: a broken archive ({error}); download it again") from None
    except Refused as refused:
        raise InputError(f"{source}: {refused}") from None
    set_aside += [SetAside(f"{source.name}: {name}", why) for name, why in odd]
    return _unwrapped(room)


def _unwrapped(room: Path) -> Path:
    while (inner := _wrapped(room)) is not None:
        room = inner
    return room


def _wrapped(room: Path) -> Path | None:
    """Return the one folder that holds all of an unpacked download, as people pack it."""
    there = list(room.iterdir())
    if len(there) != 1 or not there[0].is_dir() or any(e.who.id for e in _entries(room).entries):
        return None
    return there[0] if _entries(there[0]).entries else None


def _is_class(folder: Path) -> bool:
    """Return whether a folder is a download, which people put into another and name that.

    Gradescope's metadata are not read: a class's may take minutes, which a student's file may not.
    """
    try:
        if (_innermost(folder) / METADATA).exists():
            return True
        people = [entry.who for entry in _entries(_unwrapped(folder)).entries]
    except (InputError, OSError):
        return False
    return len({who.id or who.name for who in people if who.system != "folder"}) > 1


def _innermost(folder: Path) -> Path:
    """Return the first folder that holds more than one other."""
    while len(there := list(folder.iterdir())) == 1 and there[0].is_dir():
        folder = there[0]
    return folder


def _entries(folder: Path, roster: Roster = NOBODY, scratch: Path | None = None) -> Read:
    """Let each platform take what it knows."""
    total, left = Read(), sorted(folder.iterdir())
    left = [path for path in left if not roster.is_from(path)]
    if scratch is not None:
        here = scratch.resolve()
        left = [
            path for path in left if path.is_symlink() or not here.is_relative_to(path.resolve())
        ]
    for platform in PLATFORMS:
        found = platform.read(folder, left)
        total.entries.extend(found.entries)
        total.set_aside.extend(found.set_aside)
        left = found.left
    return total


def _nothing(sources: Sequence[Path], set_aside: Sequence[SetAside]) -> str:
    where = ", ".join(map(str, sources))
    faults = [each for each in set_aside if each.fault]
    said = f"; {faults[0].name!a}: {faults[0].reason}" if faults else ""
    return (
        f"{where}: expected a folder or an archive ({', '.join(ARCHIVES)}) per student, or a "
        f"learning platform's download; found none{said}"
    )


# --- whose is it ---------------------------------------------------------------------------------


def _students(read: Sequence[tuple[int, Entry]], roster: Roster) -> list[Student]:
    """Bring together the entries of each student."""
    same_name = Counter(
        (number, entry.who.name.casefold())
        for number, entry in {(n, e.who.name, e.who.id): (n, e) for n, e in read}.values()
    )
    folders_called: Counter[tuple[int, str]] = Counter()
    found: dict[Key, Student] = {}
    for number, entry in read:
        who = entry.who
        person = roster.find(who.system, who.name, who.id, who.email)
        nth = folders_called[number, who.name]
        folders_called[number, who.name] += 1
        key = _key(number, who, same_name[number, who.name.casefold()] > 1, nth)
        original = entry.path.name if who.system == "folder" else f"{who.name}+{who.id}"
        if person is not None:
            key, original = ("person", person.key), person.key
        student = found.setdefault(key, Student(_label(who), person, original=original))
        student.entries.append((number, entry))
    return list(found.values())


def _key(number: int, who: Who, ambiguous: bool, nth: int) -> Key:
    """Return what is the same for two entries of one student, and for no other's."""
    if who.system == "folder":
        return ("folder", who.name, nth)  # a folder and an archive of one name are two students
    if who.system == "moodle":  # whose ids are an assignment's
        apart = ambiguous or _is_blind(who)
        return ("moodle", number, who.id) if apart else ("moodle", who.name)
    if who.system == "gradescope":
        return ("gradescope", who.email or who.id or who.name)
    return (who.system, who.id or who.name)


def _label(who: Who) -> str:
    if _is_blind(who):
        return f"{who.name} {who.id}"
    return f"{who.name}_{who.id}" if who.system == "canvas" and who.id else who.name


def _is_blind(who: Who) -> bool:
    """Return whether Moodle calls everybody so: its anonymous submissions have only numbers."""
    return who.system == "moodle" and who.name.casefold() == "participant"


def _named(here: Sequence[Student], roster: Roster) -> list[Student]:
    """Give each student an id of their own; those in the roster who handed in nothing come last."""
    known = {student.person.key for student in here if student.person is not None}
    unclear = {folded(student.id) for student in here if student.person is None}
    absent = [
        Student(person.label, person, original=person.key)
        for person in roster.people
        if person.key not in known and not unclear.intersection(person.names)
    ]
    taken: set[str] = set()
    for student in [*here, *absent]:
        student.id = unique(student_id(student.id), student.original, taken)
        taken.add(student.id.casefold())
    return [*here, *absent]


# --- what is in it -------------------------------------------------------------------------------


def _fill(student: Student, room: Path, set_aside: list[SetAside]) -> None:
    for place, (number, entry) in enumerate(student.entries):
        _collect(student, entry, number, room / str(place), set_aside)
    _open_notebooks(student, room / "notebooks")


def _collect(
    student: Student, entry: Entry, number: int, room: Path, set_aside: list[SetAside]
) -> None:
    """Add an entry's files to its student's."""
    called = entry.called or entry.path.name
    if entry.path.is_symlink():
        student.problems.append(LINK)
        return
    if not entry.path.is_dir():
        _add_file(student, HandedIn(entry.path, called, entry, number), room, set_aside)
        return
    if entry.who.system == "folder" and _is_class(entry.path):
        student.problems.append(f"{called}: {CLASS}")
        return
    found, links, closed = _files(entry.path)
    student.links |= links
    student.problems += [f"{each} can't be read" for each in closed]
    handed_in = [
        HandedIn(file, file.relative_to(entry.path).as_posix(), entry, number) for file in found
    ]
    archives = [each for each in handed_in if is_archive(each.name) or is_unread_archive(each.name)]
    alone = len(archives) == 1 and not any(file.suffix.lower() == ".py" for file in found)
    student.files += [each for each in handed_in if not (alone and each is archives[0])]
    if alone:  # a folder each, with the archive in it
        _add_file(student, archives[0], room, set_aside)


def _add_file(student: Student, file: HandedIn, room: Path, set_aside: list[SetAside]) -> None:
    """Add a file, or what is in it if it is an archive."""
    if is_unread_archive(file.name):
        student.problems.append(f"{file.name}: {UNREAD}")
        return
    if not is_archive(file.name):
        student.files.append(file)
        return
    try:
        odd = unpack(file.path, room)
    except Broken as error:
        student.problems.append(f"{file.name}: a broken archive ({error}); ask for another copy")
        return
    except Refused as refused:
        student.problems.append(f"{file.name}: {refused}")
        return
    except OSError as error:
        if is_disk_full(error):
            raise
        student.problems.append(f"{file.name}: can't be read ({error.strerror})")
        return
    set_aside += [
        SetAside(f"{file.entry.path.name}: {name}", why, fault=False) for name, why in odd
    ]
    student.links |= any(why == NO_LINK for _, why in odd)
    if file.entry.who.system == "folder" and _is_class(room):
        student.problems.append(f"{file.name}: {CLASS}")
        return
    inner, *_ = _files(room)
    student.files += [
        HandedIn(path, path.relative_to(room).as_posix(), file.entry, file.source) for path in inner
    ]


def _open_notebooks(student: Student, room: Path) -> None:
    """Add the files that the notebooks' cells write."""
    there = [file for file in student.files if file.name.lower().endswith(notebooks.SUFFIX)]
    for number, file in enumerate(there[:MAX_NOTEBOOKS]):
        try:
            made = notebooks.node_files(file.path, room / str(number))
        except Refused as error:
            student.problems.append(f"{file.name}: {error}")
            continue
        student.files += [
            HandedIn(path, f"{file.name}/{path.name}", file.entry, file.source) for path in made
        ]


def _files(folder: Path) -> tuple[list[Path], bool, list[str]]:
    """Return the ordinary files below a folder, sorted, if there are links, and closed folders.

    Hidden files, links and what colcon has built are left out.
    """
    found: list[Path] = []
    closed: list[str] = []
    seen, links = 0, False

    def note(error: OSError) -> None:
        closed.append(os.path.relpath(error.filename, folder.parent))

    for where, inner, files in os.walk(folder, onerror=note, followlinks=False):
        depth = len(Path(where).relative_to(folder).parts)
        if depth and not set(files).isdisjoint(MADE):
            inner[:] = []
            continue
        links |= any(Path(where, name).is_symlink() for name in [*inner, *files])
        inner[:] = sorted(f for f in inner if may_enter(f)) if depth < MAX_DEPTH else []
        for name in sorted(files):
            path = Path(where, name)
            seen += 1
            if not name.startswith(".") and stat.S_ISREG(path.lstat().st_mode):
                found.append(path)
        if seen > MAX_LISTED:
            break
    return found, links, closed
