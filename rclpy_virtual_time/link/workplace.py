"""The folder in which hosts work, and what they take of the machine there and elsewhere.

Where mounts are to be had the folder is a file system of its own, and where users are, the kernel
counts processes. Elsewhere the judge looks, from the start-up on, and ends what takes too much.
"""

from __future__ import annotations

import contextlib
import errno
import itertools
import os
import stat
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from rclpy_virtual_time.host.sandbox.amounts import (
    MAX_FILE,
    MAX_FOLDER,
    MAX_FOLDER_FILES,
    MAX_PROCESSES,
)
from rclpy_virtual_time.link.real_clock import real_clock

BLOCK = 512  # [bytes] the unit of st_blocks, on any file system
THREADS = 17  # where /proc/PID/stat counts them, after the process's name
MAPS_EVERY = 0.1  # [s] between looks at a process's maps, which are long
IN_FOLDER = f"{MAX_FOLDER_FILES:,} files or {MAX_FOLDER:,} bytes in its folder"


class Excess(Exception):
    """The node took more of the machine than it may."""


@dataclass(frozen=True)
class Workplace:
    """A folder that hosts work in."""

    folder: Path  # as they know it
    seen: Path  # the same, for the judge: it may lie where only hosts look
    user: int  # of its hosts [uid]; 0: the judge's own
    descriptor: int = -1  # of the folder, if the kernel limits what it holds

    @property
    def limited(self) -> bool:
        """Return whether the kernel limits what the folder holds."""
        return self.descriptor >= 0


@dataclass
class Watch:
    """The judge's look at one host: what it takes of the machine."""

    pid: int
    place: Workplace
    counted: bool  # the kernel limits its processes and threads
    _mapped: int = 0  # [bytes] of files without a name that it has mapped, at most
    _asked: float = -MAPS_EVERY  # [s] when that was looked at

    def look(self) -> None:
        """Make sure that the host takes no more than it may; cheap enough for every exchange.

        Raises Excess: it has taken too much.
        """
        if self.place.limited:
            space = os.statvfs(self.place.descriptor)
            if not (space.f_bfree and space.f_ffree):
                raise Excess(f"its folder is full, at {IN_FOLDER}")
        self.patrol()

    def patrol(self) -> None:
        """Check a working host where the kernel sets no limit; raises as `look` does."""
        if not self.place.limited:
            now = real_clock.monotonic()
            if now - self._asked >= MAPS_EVERY:
                self._mapped, self._asked = mapped_of(self.pid), now
            check_folder(self.place.folder, self._mapped + unlinked_of(self.pid))
        if not self.counted and threads_of(self.pid) > MAX_PROCESSES:
            raise Excess(f"more than {MAX_PROCESSES} threads")


def check_folder(folder: Path, hidden: int = 0) -> None:
    """Make sure that a node doesn't fill the disk; `hidden` [bytes] are not in the folder.

    Raises Excess: there are too many, or they are too large.
    """
    size = hidden
    for count, entry in enumerate(_entries(folder), start=1):
        with contextlib.suppress(OSError):
            size += entry.stat(follow_symlinks=False).st_blocks * BLOCK
        if size > MAX_FOLDER or count > MAX_FOLDER_FILES:
            raise Excess(f"more than {IN_FOLDER}")
    if size > MAX_FOLDER:
        raise Excess(f"more than {IN_FOLDER}")


def threads_of(pid: int) -> int:
    """Return how many threads a process has; 0 if it is gone."""
    try:
        fields = Path(f"/proc/{pid}/stat").read_bytes().rpartition(b")")[2].split()
        return int(fields[THREADS])
    except OSError:
        return 0


def mapped_of(pid: int) -> int:
    """Return how much the mapped files of a process can hold that have no name any more [bytes].

    How much they do hold only root could see, so each counts as the largest that there can be.
    """
    try:
        lines = Path(f"/proc/{pid}/maps").read_bytes().splitlines()
    except OSError:
        return 0
    gone = (line.split(None, 5) for line in lines if line.endswith(b"(deleted)"))
    files = {(f[3], f[4]) for f in gone if not f[5].startswith((b"/dev/", b"/memfd:", b"/SYSV"))}
    return len(files) * MAX_FILE


def unlinked_of(pid: int) -> int:
    """Return how much the open files of a process hold that have no name any more [bytes]."""
    size = 0
    with contextlib.suppress(OSError), os.scandir(f"/proc/{pid}/fd") as descriptors:
        for descriptor in descriptors:
            with contextlib.suppress(OSError):
                status = descriptor.stat()
                if stat.S_ISREG(status.st_mode) and not status.st_nlink:
                    size += status.st_blocks * BLOCK
    return size


def _entries(folder: Path) -> Iterator[os.DirEntry[str]]:
    """Return what lies in a folder; without recursion, because it may be deep.

    Raises Excess: it is deeper than a path may be long: what lies there can't be counted.
    """
    pending = [str(folder)]
    while pending:
        try:
            with os.scandir(pending.pop()) as entries:
                found = list(itertools.islice(entries, MAX_FOLDER_FILES + 1))
        except OSError as error:
            if error.errno == errno.ENAMETOOLONG:
                raise Excess("folders in one another without end") from None
            continue  # gone, or closed to the judge: then nobody else can use it either
        yield from found
        pending += [entry.path for entry in found if entry.is_dir(follow_symlinks=False)]
