"""Temporary folders, and the clean-up of those that a killed grader left behind."""

from __future__ import annotations

import contextlib
import os
import re
import secrets
import stat
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

_OURS = re.compile(r"course-([0-9]+)-.*")


def prefix() -> str:
    """Return the prefix of this process's temporary folders, which names the process."""
    return f"course-{os.getpid()}-"


def sweep() -> None:
    """Remove the folders of graders that no longer run: a killed grader leaves its own."""
    if not Path("/proc").is_dir():
        return  # not Linux: nobody tells here which processes live
    from rclpy_virtual_time.host.sandbox.users import USERS  # noqa: PLC0415  (only Linux can import it)

    for entry in list(os.scandir(tempfile.gettempdir())):
        match = _OURS.fullmatch(entry.name)
        if match and not Path(f"/proc/{match[1]}").exists():
            with contextlib.suppress(OSError):
                status = entry.stat(follow_symlinks=False)
                if stat.S_ISDIR(status.st_mode) and status.st_uid in (os.geteuid(), *USERS):
                    remove(Path(entry))


@contextlib.contextmanager
def fresh_folder() -> Iterator[Path]:
    """Make a temporary folder that may be given away; it goes when the block ends."""
    folder = Path(tempfile.mkdtemp(prefix=prefix())).resolve()
    try:
        yield folder
    finally:
        with contextlib.suppress(OSError):
            remove(folder)


def remove(top: Path) -> None:
    """Remove a folder with everything that a student's node put into it.

    Folders are moved to the top before they are emptied: they may be nested deeper than the
    longest path, or Python's stack, allows. A link in the place of the folder leads nowhere.
    """
    if top.is_symlink():
        top.unlink()
        return
    pending = [top]
    while pending:
        folder = pending.pop()
        folder.chmod(stat.S_IRWXU)
        for entry in list(os.scandir(folder)):
            if not entry.is_dir(follow_symlinks=False):
                Path(entry).unlink()
                continue
            Path(entry).chmod(stat.S_IRWXU)
            raised = top / secrets.token_hex(16)
            Path(entry).rename(raised)
            pending.append(raised)
        if folder != top:
            folder.rmdir()
    top.rmdir()


def open_regular_file(path: Path) -> BinaryIO:
    """Open a submitted file, or a file that a student's program wrote.

    Raises OSError: it can't be read, is a link, or is not a regular file.
    """
    fd = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC)
    if not stat.S_ISREG(os.fstat(fd).st_mode):
        os.close(fd)
        raise OSError(0, "not an ordinary file", str(path))
    return open(fd, "rb")
