"""Take in what a class handed in: find the students, unpack archives, find each exercise's files.

Nothing here is trusted: an archive may be broken, locked, a bomb or a trap, and a folder may hold
links to the instructor's files. A student whose files can't be read gets a `problem`; the others
are not held up.
"""

from __future__ import annotations

import contextlib
import gzip
import hashlib
import io
import os
import re
import stat
import tarfile
import unicodedata
import zipfile
from collections.abc import Container, Generator, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import IO, Any

from grader.course.submission import open_regular_file, read_regular_file
from grader.errors import InputError, is_disk_full

ARCHIVES = (".zip", ".tar", ".tar.gz", ".tgz")
MAX_MEMBERS = 5_000  # of an archive
MAX_UNPACKED = 100 * 1024 * 1024  # [bytes] of an archive
MAX_RATIO = 200  # unpacked to packed size, above SMALL; source code has about 5
SMALL = 4 * 1024 * 1024  # [bytes]
MAX_DEPTH = 6  # folders below a student's
MAX_LISTED = 20_000  # files of a student's folder that are listed
MAX_NAME = 80  # [characters] of a student's id
MARK = 6  # [characters] that tell two of one name apart
MARKED = re.compile(rf"~[0-9a-f]{{{MARK},}}$", re.IGNORECASE)
CHUNK = 64 * 1024  # [bytes]
NOT_THEIRS = {"__MACOSX", "__pycache__", "node_modules", "venv", "site-packages"}
COPIED = re.compile(r"(\s*\(\d+\)|-\d+|\s+-?\s*copy)$", re.IGNORECASE)  # "agent (1).py", "agent-2"


@dataclass(frozen=True)
class Student:
    """One who handed something in."""

    id: str  # a safe name for a folder
    path: Path  # the folder with the files
    problem: str = ""  # why the files can't be read; "" if they can


@dataclass(frozen=True)
class Found:
    """The files of one exercise that a student handed in, by the names the exercise gives them."""

    files: dict[str, Path]
    problem: str = ""  # why nothing can be graded; "" if it can
    remark: str = ""  # what the instructor may want to know


class _Refused(Exception):
    """An archive is not unpacked; the message says why."""


def find_students(folder: Path, scratch: Path) -> list[Student]:
    """Return the students of a class: each folder or archive in `folder` is one.

    Archives are unpacked below `scratch`.

    Raises
    ------
    InputError
        `folder` is no folder, or holds neither folders nor archives.
    """
    if not folder.is_dir():
        raise InputError(f"{folder}: expected a folder with a folder or an archive per student")
    entries = [path for path in sorted(folder.iterdir()) if _is_student(path)]
    if not entries:
        raise InputError(
            f"{folder}: expected a folder or an archive ({', '.join(ARCHIVES)}) per student, "
            "found none"
        )
    entries.sort(key=lambda path: (not path.is_dir(), path.name))  # a folder keeps its plain name
    students: dict[str, Student] = {}
    for path in entries:
        name = _unique(student_id(_stem(path)), path.name, students)
        students[name.casefold()] = _student(name, path, scratch / name)
    return sorted(students.values(), key=lambda student: student.id)


def student_id(name: str) -> str:
    """Return a name that looks the same and is safe for a folder: NFC, no separators, no dots."""
    text = unicodedata.normalize("NFC", name.encode("utf-8", "replace").decode("utf-8"))
    text = "".join(c if c.isprintable() and c not in '/\\:*?"<>|' else "_" for c in text)
    text = text.strip(" .")[:MAX_NAME].strip(" .")
    while len(text.encode()) > 200:  # a file system counts bytes
        text = text[:-1]
    return text or "unnamed"


def find_files(student: Student, names: Sequence[str]) -> Found:
    """Return a student's files called `names`; the first one is required.

    Of several, the one nearest to the top counts. Names may differ in case, and may have the suffix
    that a browser gives a second copy.
    """
    if student.problem:
        return Found({}, student.problem)
    there = sorted(_files(student.path), key=lambda path: (len(path.parts), str(path)))
    first, *others = names
    candidates = _called(first, there)
    if not candidates:
        return Found({}, f"expected a file {first}; {_inventory(student.path, there)}")
    chosen = candidates[0]
    found = {first: chosen}
    for other in others:
        same = _called(other, there)
        beside = [path for path in same if path.parent == chosen.parent]
        if same:
            found[other] = (beside or same)[0]
    remark = ""
    if len({_content(path) for path in candidates}) > 1:
        where = chosen.relative_to(student.path)
        remark = f"{student.id}: {len(candidates)} different files {first}; {where} was graded"
    return Found(found, remark=remark)


def _is_student(path: Path) -> bool:
    if path.name.startswith(".") or path.name in NOT_THEIRS:
        return False
    return path.is_dir() or _is_archive(path.name)


def _is_archive(name: str) -> bool:
    return name.lower().endswith(ARCHIVES)


def _stem(path: Path) -> str:
    suffix = next((s for s in (".tar.gz", *ARCHIVES) if path.name.lower().endswith(s)), "")
    return path.name[: -len(suffix)] if suffix and not path.is_dir() else path.name


def _unique(name: str, original: str, taken: Container[str]) -> str:
    """Return the name, marked if another student has it; the same mark in every run.

    Who hands in a name that looks marked gets a mark, too: nobody can choose another's.
    """
    if not MARKED.search(name) and name.casefold() not in taken:
        return name
    digest = hashlib.sha256(original.encode("utf-8", "surrogateescape")).hexdigest()
    lengths = range(MARK, len(digest) + 1)  # of two files in a folder, the names differ
    marked = (f"{name}~{digest[:length]}" for length in lengths)
    return next(each for each in marked if each.casefold() not in taken)


def _student(name: str, path: Path, room: Path) -> Student:
    if path.is_symlink():
        return Student(name, path, "a link, which is not followed; expected a folder or an archive")
    if path.is_dir():
        inner = [file for file in _files(path) if _is_archive(file.name)]
        if len(inner) != 1 or any(file.suffix.lower() == ".py" for file in _files(path)):
            return Student(name, path)
        path = inner[0]  # as learning platforms export it: a folder each, with the archive in it
    try:
        _unpack(path, room)
    except _Refused as refused:
        return Student(name, room, f"{path.name}: {refused}")
    except Exception as error:  # whatever a malicious file makes zipfile and tarfile raise
        if is_disk_full(error):  # not the archive's fault, which is limited
            raise
        kind = type(error).__name__
        text = f"{path.name}: a broken archive ({kind}: {str(error)[:200]}); ask for another copy"
        return Student(name, room, " ".join(text.split()))
    return Student(name, room)


def _files(folder: Path) -> list[Path]:
    """Return the ordinary files below a folder, sorted; hidden files and links are left out."""
    found: list[Path] = []
    seen = 0
    for where, folders, files in os.walk(folder, followlinks=False):
        depth = len(Path(where).relative_to(folder).parts)
        folders[:] = sorted(f for f in folders if _may_enter(f)) if depth < MAX_DEPTH else []
        for name in sorted(files):
            path = Path(where, name)
            seen += 1
            if not name.startswith(".") and stat.S_ISREG(path.lstat().st_mode):
                found.append(path)
        if seen > MAX_LISTED:
            break
    return found


def _may_enter(name: str) -> bool:
    return not name.startswith(".") and name not in NOT_THEIRS


def _called(name: str, paths: Sequence[Path]) -> list[Path]:
    """Return the files of that name; if there are none, those with an equivalent name."""
    exact = [path for path in paths if path.name == name]
    if exact:
        return exact
    return [path for path in paths if _plain(path.name) == _plain(name)]


def _plain(name: str) -> str:
    stem, dot, suffix = unicodedata.normalize("NFC", name).casefold().rpartition(".")
    return COPIED.sub("", stem.strip()) + dot + suffix


def _inventory(folder: Path, there: Sequence[Path]) -> str:
    links = any(entry.is_symlink() for entry in folder.iterdir())
    return _listed(folder, there) + (" (links are not followed)" if links else "")


def _listed(folder: Path, there: Sequence[Path]) -> str:
    if not there:
        return "there are no files"
    names = [str(path.relative_to(folder)) for path in there]
    python = [name for name in names if name.lower().endswith(".py")] or names
    shown = ", ".join(ascii(name)[1:-1] if not name.isprintable() else name for name in python[:5])
    text = f"there is {shown}" + (" and more" if len(python) > 5 else "")
    if any(map(_is_archive, names)):
        text += " (archives inside are not unpacked)"
    return text


def _content(path: Path) -> bytes:
    try:
        return hashlib.sha256(read_regular_file(path)).digest()
    except OSError:
        return b""


def _unpack(archive: Path, room: Path) -> None:
    room.mkdir(parents=True, exist_ok=True)
    left = _Allowance(min(MAX_UNPACKED, max(SMALL, MAX_RATIO * archive.stat().st_size)))
    is_zip = archive.name.lower().endswith(".zip")
    with contextlib.closing(_zip(archive) if is_zip else _tar(archive, left)) as members:
        _write(members, room, left)


def _write(members: Iterable[tuple[str, IO[bytes]]], room: Path, left: _Allowance) -> None:
    for name, source in members:
        target = _inside(room, name)
        if target is None:
            continue
        target.parent.mkdir(parents=True, exist_ok=True)
        if target.exists():
            continue  # the same name twice: the first counts
        with source, target.open("wb") as file:
            while chunk := source.read(CHUNK):
                left.take(len(chunk))
                file.write(chunk)


class _Allowance:
    """How much an archive may still unpack to."""

    def __init__(self, size: int) -> None:
        self._left = size  # [bytes]
        self._members = MAX_MEMBERS

    def take(self, size: int) -> None:
        self._left -= size
        if self._left < 0:
            raise _Refused("over 100 MiB, or far larger unpacked than packed; not unpacked")

    def member(self) -> None:
        self._members -= 1
        if self._members < 0:
            raise _Refused(f"over {MAX_MEMBERS:,} files; not unpacked")


def _inside(room: Path, name: str) -> Path | None:
    """Return where a member is unpacked to; None if it is skipped."""
    parts = PurePosixPath(name.replace("\\", "/")).parts
    if not parts or parts[0] == "/" or ".." in parts or re.match(r"^[A-Za-z]:", name):
        raise _Refused(f"holds {name[:80]!r}, which points outside of it; not unpacked")
    if not all(map(_may_enter, parts)) or len(parts) > MAX_DEPTH + 1:
        return None
    return room.joinpath(*parts)


def _zip(archive: Path) -> Generator[tuple[str, IO[bytes]], None, None]:
    with open_regular_file(archive) as file, zipfile.ZipFile(file) as opened:
        members = opened.infolist()
        if len(members) > MAX_MEMBERS:
            raise _Refused(f"over {MAX_MEMBERS:,} files; not unpacked")
        if any(member.flag_bits & 1 for member in members):
            raise _Refused("locked with a password; ask for one without")
        for member in members:
            mode = stat.S_IFMT(member.external_attr >> 16)
            if not member.is_dir() and mode in (0, stat.S_IFREG):
                yield member.filename, opened.open(member)


def _tar(archive: Path, left: _Allowance) -> Generator[tuple[str, IO[bytes]], None, None]:
    with contextlib.ExitStack() as stack:
        packed: Any = stack.enter_context(open_regular_file(archive))
        if not archive.name.lower().endswith(".tar"):
            packed = stack.enter_context(gzip.GzipFile(fileobj=packed))
        counted: Any = _Counted(packed, _Allowance(2 * MAX_UNPACKED))
        opened = stack.enter_context(tarfile.open(fileobj=counted, mode="r|"))
        for member in opened:
            left.member()
            if member.isreg() and (source := opened.extractfile(member)) is not None:
                yield member.name, source


class _Counted(io.RawIOBase):
    """A stream that raises `_Refused` when the allowance is used up: a tar.gz may be endless."""

    def __init__(self, stream: IO[bytes], left: _Allowance) -> None:
        self._stream = stream
        self._left = left

    def read(self, size: int = -1) -> bytes:
        data = self._stream.read(size)
        self._left.take(len(data))
        return data
