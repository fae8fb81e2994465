"""From downloads to students: read them, unpack archives, bring together what is one's."""

import os
import stat
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path

from grader.classroom.intake import notebooks, whose
from grader.classroom.intake.handed_in import WORK, HandedIn, Student
from grader.classroom.intake.skeletons import is_handed_out
from grader.classroom.intake.whose import NOTHING_KNOWN, Known
from grader.course.beside import MADE, MAX_FILES
from grader.errors import InputError, is_disk_full
from grader.lms.folders import LITTER
from grader.lms.folders import PLATFORM as FOLDERS
from grader.lms.names import may_enter
from grader.lms.people import NOBODY, Roster
from grader.lms.platform import Entry, Read, SetAside, Who
from grader.lms.platforms import PLATFORMS
from grader.lms.unpack import ARCHIVES, MAX_DEPTH, is_archive, is_unread_archive, unpack
from grader.lms.unpack import LINK as NO_LINK
from grader.nbgrader.exported import SUFFIX, may_be_notebook
from rclpy_virtual_time import FileReader

MAX_LISTED = 20_000  # files of a student's folder that are listed
MAX_NOTEBOOKS = 50  # of a student that are opened
MAX_ARCHIVES = 10  # beside each other, of a student
MAX_PACKED = 2  # archives in one another
LINK = "a link, which is not followed; expected a folder or an archive"
CLASS = "the work of several students, not of one; name it itself on the command line"
UNREAD = f"an archive that is not read; ask for one of {', '.join(ARCHIVES)}"


@dataclass(frozen=True)
class Intake:
    """A class as it was handed in."""

    students: list[Student]  # by id; with a roster everybody in it
    set_aside: list[SetAside]  # what is in the downloads and nobody's work


def take_in(
    sources: Sequence[Path], scratch: Path, roster: Roster = NOBODY, known: Known = NOTHING_KNOWN
) -> Intake:
    """Return the students whose work lies in `sources`: folders, or a platform's archives.

    Archives are unpacked below `scratch`; a folder of a source that holds it is nobody's. Everybody
    in the roster is a student.

    Raises InputError: a source can't be read, or there is nothing in them.
    """
    set_aside: list[SetAside] = []
    read: list[tuple[int, Entry]] = []
    unclear: list[list[tuple[int, Entry]]] = []
    for number, source in enumerate(sources):
        folder = _opened(source, scratch / ".downloads" / str(number), set_aside)
        found = _entries(folder, roster, scratch)
        read += [(number, entry) for entry in found.entries]
        unclear += [[(number, each) for each in readings] for readings in found.unclear]
        set_aside += found.set_aside
    found_students, nobodys = whose.students(read, unclear, roster, known)
    set_aside += nobodys
    if not found_students:
        raise InputError(_nothing(sources, set_aside))
    for student in found_students:
        _fill(student, scratch / student.id, set_aside)
    return Intake(sorted(found_students, key=lambda student: student.id), set_aside)


def take_in_one(folder: Path, scratch: Path) -> Student:
    """Return the student whose work, and nobody else's, lies in a folder."""
    student = Student("submission", entries=[(0, Entry(folder, Who("submission", FOLDERS)))])
    _fill(student, scratch, [])
    return student


def _opened(source: Path, room: Path, set_aside: list[SetAside]) -> Path:
    """Return the folder with the entries of a download; an archive is unpacked first."""
    if source.is_dir():
        return _download_in(source)
    if not os.path.lexists(source):
        raise InputError(f"{source}: expected what the class has handed in; nothing is there")
    if not source.is_file() or not is_archive(source.name):
        raise InputError(
            f"{source}: expected a folder with a folder or an archive per student, or the archive "
            f"of a learning platform ({', '.join(ARCHIVES)})"
        )
    try:
        odd = unpack(source, room, of_class=True)
    except FileReader.Broken as error:
        raise InputError(f"{source}: a broken archive ({error}); download it again") from None
    except FileReader.Refused as refused:
        raise InputError(f"{source}: {refused}") from None
    set_aside += [SetAside(f"{source.name}: {name}", why) for name, why in odd]
    return _unwrapped(room)


def _wrapped(folder: Path) -> Iterator[Path]:
    """Yield a folder, and each that is all that is in the one above, but for what systems leave."""
    yield folder
    there = [path for path in folder.iterdir() if may_enter(path.name) and path.name not in LITTER]
    if len(there) == 1 and there[0].is_dir() and not there[0].is_symlink():
        yield from _wrapped(there[0])


def _unwrapped(room: Path) -> Path:
    """Return the folder with the entries of an unpacked download, as people pack it."""
    for inner in islice(_wrapped(room), 1, None):
        if any(e.who.id for e in _entries(room).entries) or not _entries(inner).entries:
            break
        room = inner
    return room


def _download_in(source: Path) -> Path:
    """Return a platform's download in folders that hold nothing else; without one the source."""
    try:
        return next(filter(_is_platforms, _wrapped(source)), source)
    except OSError:  # a student's, which nobody may open
        return source


def _is_platforms(folder: Path) -> bool:
    return any(entry.who.platform is not FOLDERS for entry in _entries(folder).entries)


def _is_class(folder: Path) -> bool:
    """Return whether a folder is a download, which people put into another and name that.

    Metadata are not read: a class's may take minutes, which a student's file may not.
    """
    names = [platform.metadata for platform in PLATFORMS if platform.metadata]
    try:
        if any((each / name).exists() for each in _wrapped(folder) for name in names):
            return True
        people = [entry.who for entry in _entries(_unwrapped(folder)).entries]
    except (InputError, OSError):
        return False
    return len({who.id or who.name for who in people if who.platform is not FOLDERS}) > 1


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
        total.unclear.extend(found.unclear)
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


# --- what is in it -------------------------------------------------------------------------------


def _fill(student: Student, room: Path, set_aside: list[SetAside]) -> None:
    for place, (number, entry) in enumerate(student.entries):
        _collect(student, entry, number, room / str(place), set_aside)
    _open_notebooks(student, room / "notebooks", set_aside)


def _collect(
    student: Student, entry: Entry, number: int, room: Path, set_aside: list[SetAside]
) -> None:
    """Add an entry's files to its student's."""
    called = entry.called or entry.path.name
    if entry.path.is_symlink():
        student.problems.append(LINK)
        return
    files = [HandedIn(entry.path, called, entry, number)]
    if entry.path.is_dir():
        if entry.who.platform is FOLDERS and _is_class(entry.path):
            student.problems.append(f"{called}: {CLASS}")
            return
        found, links, closed = _files(entry.path)
        student.links |= links
        student.problems += [f"{each} can't be read" for each in closed]
        files = [HandedIn(each, each.relative_to(entry.path).as_posix(), entry, number)
                 for each in found]  # fmt: skip
    student.files += _opened_up(student, files, room, set_aside)


def _opened_up(
    student: Student, files: Sequence[HandedIn], room: Path, set_aside: list[SetAside],
    deep: int = MAX_PACKED,
) -> list[HandedIn]:  # fmt: skip
    """Return files; where none is Python, what is in archives counts in their place."""
    archives = [each for each in files if is_archive(each.name)
                or (deep == MAX_PACKED and is_unread_archive(each.name))]  # fmt: skip
    too_many = len(archives) > MAX_ARCHIVES
    if not deep or too_many or any(each.name.lower().endswith(".py") for each in files):
        return list(files)
    found = [each for each in files if each not in archives]
    for number, archive in enumerate(archives):
        inside = _unpacked(student, archive, room / f"{number}", set_aside)
        found += _opened_up(student, inside, room / f"{number}.in", set_aside, deep - 1)
    return found


def _unpacked(
    student: Student, file: HandedIn, room: Path, set_aside: list[SetAside]
) -> list[HandedIn]:
    if is_unread_archive(file.name):
        student.problems.append(f"{file.name}: {UNREAD}")
        return []
    try:
        odd = unpack(file.path, room)
    except FileReader.Broken as error:
        student.problems.append(f"{file.name}: a broken archive ({error}); ask for another copy")
        return []
    except FileReader.Refused as refused:
        student.problems.append(f"{file.name}: {refused}")
        return []
    except OSError as error:
        if is_disk_full(error):
            raise
        student.problems.append(f"{file.name}: can't be read ({error.strerror})")
        return []
    set_aside += [
        SetAside(f"{file.entry.path.name}: {name}", why, fault=False) for name, why in odd
    ]
    student.links |= any(why == NO_LINK for _, why in odd)
    if file.entry.who.platform is FOLDERS and _is_class(room):
        student.problems.append(f"{file.name}: {CLASS}")
        return []
    inner, *_ = _files(room)
    return [
        HandedIn(path, path.relative_to(room).as_posix(), file.entry, file.source) for path in inner
    ]


def _open_notebooks(student: Student, room: Path, set_aside: list[SetAside]) -> None:
    there = [file for file in student.files if file.name.lower().endswith(SUFFIX)]
    programs = [file for file in student.files if file.name.lower().endswith(WORK)]
    there += [file for file in programs[:MAX_FILES]
              if may_be_notebook(file.path) and not is_handed_out(file.path)]  # fmt: skip
    for number, file in enumerate(there[:MAX_NOTEBOOKS]):
        own = room / str(number)
        found: tuple[list[Path], list[str]] | None = [], []
        try:
            found = notebooks.node_files(file.path, own)
        except FileReader.Refused as error:
            student.problems.append(f"{file.name}: {error}")
        if found is None:
            continue
        made, remarks = found
        set_aside += [SetAside(f"{student.id}: {file.name}", each, fault=False) for each in remarks]
        if file in programs:
            student.files[student.files.index(file)] = replace(file, opened=True)
        student.files += [
            HandedIn(path, f"{file.name}/{path.relative_to(own).as_posix()}", file.entry,
                     file.source) for path in made
        ]  # fmt: skip


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
