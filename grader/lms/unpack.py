"""Unpack a zip or a tar that somebody handed in, and nothing outside of the folder given.

It happens in a process with limits (`rclpy_virtual_time/link/cell.py`): a tar's header, for one,
can take tarfile hours (CVE-2024-6232).
"""

from __future__ import annotations

import contextlib
import gzip
import io
import re
import stat
import tarfile
import zipfile
from collections.abc import Generator, Iterable
from pathlib import Path, PurePosixPath
from typing import IO, Any

from grader.errors import is_disk_full
from grader.lms.names import may_enter, uncopied
from rclpy_virtual_time import FileReader

ARCHIVES = (".zip", ".tar", ".tar.gz", ".tgz")
# Recognised and not unpacked. A 7z's header chooses how much memory its decoder takes, up to 4 GiB,
# and Python's lzma has no limit for it; rar needs a program that is not free (docs/decisions.md).
UNREAD = (
    ".7z", ".rar", ".tar.bz2", ".tbz2", ".tar.xz", ".txz", ".tar.zst", ".gz", ".bz2", ".xz", ".zst",
)  # fmt: skip
READ = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)  # of a zip's; others unpack a member at once
MAX_MEMBERS = 5_000  # of a student's archive
MAX_UNPACKED = 100 * 1024 * 1024  # [bytes] of a student's archive
MAX_RATIO = 200  # unpacked to packed size, above SMALL; source code has about 5
SMALL = 4 * 1024 * 1024  # [bytes]
MAX_DEPTH = 6  # folders below a student's
MANY = 100  # a class's download may have so many times more
CUT = 20 * 1024 * 1024  # [bytes] of a file in a class's download: one can't keep out the others
CHUNK = 64 * 1024  # [bytes]
UTF_8 = 0x800  # flag of a zip's member: its name is UTF-8, else code page 437, says the format


LINK = "a link, which is not followed"
MOST_ODD = 1_000  # that are told
NAME = 200  # [characters] of a name that is told

# a platform's file of a whole class
OF_CLASS = FileReader(memory=1024 << 20, cpu=900, file=1024 << 20, answer=64 << 20)

Odd = tuple[str, str]  # a member's name, and what is odd about it


def is_archive(name: str) -> bool:
    return uncopied(name).lower().endswith(ARCHIVES)  # Canvas: hw.tar-1.gz


def is_unread_archive(name: str) -> bool:
    """Return whether files called so are archives that are not unpacked."""
    return name.lower().endswith(UNREAD) and not is_archive(name)


def archive_stem(name: str) -> str:
    if is_archive(name) and not name.lower().endswith(ARCHIVES):
        name = uncopied(name)
    lower = name.lower()
    suffixes = sorted((*ARCHIVES, *UNREAD), key=len, reverse=True)
    suffix = next((each for each in suffixes if lower.endswith(each)), "")
    return name[: len(name) - len(suffix)]


def unpack(archive: Path, room: Path, *, of_class: bool = False) -> list[Odd]:
    """Unpack a student's archive, or a platform's of a class, into `room`; return what is odd.

    Of a class's, files that are too long are cut off, and those with impossible names left out:
    nobody's can keep out the others.

    Raises FileReader.Refused: it is locked, a trap, or broken.
    """
    many = MANY if of_class else 1
    size = stream = many * MAX_UNPACKED
    if not of_class:
        size = min(size, max(SMALL, MAX_RATIO * archive.stat().st_size))
    depth, cut = (MAX_DEPTH + 3, CUT) if of_class else (MAX_DEPTH + 1, None)
    room.mkdir(parents=True, exist_ok=True)
    suffix = archive.name.lower().rpartition(".")[2]
    reader = OF_CLASS if of_class else FileReader()
    return reader.read(
        unpack_here, suffix, size, 2 * stream, many * MAX_MEMBERS, depth, cut,
        file=archive, room=room, returns=list[Odd],
    )  # fmt: skip


def unpack_here(
    archive: IO[bytes],
    room: Path,
    suffix: str,
    size: int,
    stream: int,
    files: int,
    depth: int,
    cut: int | None,
) -> list[Odd]:
    """Unpack an archive in this process: `size` bytes at most, `files` files, `depth` deep.

    Of a tar at most `stream` bytes are read, with what is skipped.
    """
    left = _Allowance(size, files)
    members = (
        _zip(archive, left) if suffix == "zip" else _tar(archive, left, suffix == "tar", stream)
    )
    with contextlib.closing(members):
        odd = _write(members, room, left, depth, cut)
    return [(name[:NAME].encode("utf-8", "replace").decode(), why) for name, why in odd[:MOST_ODD]]


def _write(
    members: Iterable[tuple[str, IO[bytes] | None]],
    room: Path,
    left: _Allowance,
    depth: int,
    cut: int | None,
) -> list[Odd]:
    odd = []
    for name, source in members:
        if source is None:
            odd.append((name, LINK))
            continue
        try:
            target = _inside(room, name, depth)
            if target is None:
                continue
            target.parent.mkdir(parents=True, exist_ok=True)
            if target.exists():
                odd.append((name, "twice in the archive; the first counts"))
                continue
            target.touch(exist_ok=False)
        except (FileReader.Refused, OSError) as error:
            if cut is None or is_disk_full(error):
                raise
            why = str(error)  # one can't keep out the others
            if isinstance(error, OSError):  # too long a name, or a member is a folder called so
                why = f"can't be written ({error.strerror}); ask for another name"
            odd.append((name, why))
            continue
        size = 0
        with source, target.open("wb") as file:
            while chunk := source.read(CHUNK):
                size += len(chunk)
                if cut is not None and size > cut:
                    odd.append((name, f"over {cut // 2**20} MiB, so its end was cut off"))
                    break
                left.take(len(chunk))
                file.write(chunk)
    return odd


class _Allowance:
    """How much an archive may still unpack to."""

    def __init__(self, size: int, members: int) -> None:
        self.size = self._left = size  # [bytes]
        self._most = self._members = members

    def take(self, size: int) -> None:
        self._left -= size
        if self._left < 0:
            most = max(self.size, MAX_UNPACKED) // 2**20
            raise FileReader.Refused(
                f"over {most:,} MiB, or far larger unpacked than packed; not unpacked"
            )

    def member(self) -> None:
        self._members -= 1
        if self._members < 0:
            raise FileReader.Refused(f"over {self._most:,} files; not unpacked")


def _inside(room: Path, name: str, depth: int) -> Path | None:
    """Return where a member is unpacked to; None if it is skipped."""
    parts = PurePosixPath(name.replace("\\", "/")).parts
    if not parts or parts[0] == "/" or ".." in parts or re.match(r"^[A-Za-z]:", name):
        raise FileReader.Refused(f"holds {name[:80]!r}, which points outside of it; not unpacked")
    if not all(map(may_enter, parts)) or len(parts) > depth:
        return None
    return room.joinpath(*parts)


def _zip(
    archive: IO[bytes], left: _Allowance
) -> Generator[tuple[str, IO[bytes] | None], None, None]:
    with zipfile.ZipFile(archive) as opened:
        members = opened.infolist()
        for _ in members:
            left.member()
        if any(member.flag_bits & 1 for member in members):
            raise FileReader.Refused("locked with a password; ask for one without")
        if any(member.compress_type not in READ for member in members):
            raise FileReader.Refused("packed by a rare method; ask for an ordinary zip (“deflate”)")
        for member in members:
            mode = stat.S_IFMT(member.external_attr >> 16)
            if mode == stat.S_IFLNK:
                yield _name(member), None
            elif not member.is_dir() and mode in (0, stat.S_IFREG):
                yield _name(member), opened.open(member)


def _name(member: zipfile.ZipInfo) -> str:
    """Return a member's name, which macOS and Linux write in UTF-8 without saying so."""
    if member.flag_bits & UTF_8:
        return member.filename
    with contextlib.suppress(UnicodeError):
        return member.filename.encode("cp437").decode("utf-8")
    return member.filename


def _tar(
    archive: IO[bytes], left: _Allowance, plain: bool, most: int
) -> Generator[tuple[str, IO[bytes] | None], None, None]:
    with contextlib.ExitStack() as stack:
        packed: Any = archive
        if not plain:
            packed = stack.enter_context(gzip.GzipFile(fileobj=packed))
        counted: Any = _Counted(packed, _Allowance(most, 0))
        opened = stack.enter_context(tarfile.open(fileobj=counted, mode="r|"))
        for member in opened:
            left.member()
            if member.issym() or member.islnk():
                yield member.name, None
            elif member.isreg() and (source := opened.extractfile(member)) is not None:
                yield member.name, source


class _Counted(io.RawIOBase):
    """A stream that is refused when the allowance is used up: a tar.gz may be endless."""

    def __init__(self, stream: IO[bytes], left: _Allowance) -> None:
        self._stream = stream
        self._left = left

    def read(self, size: int = -1) -> bytes:
        data = self._stream.read(size)
        self._left.take(len(data))
        return data
