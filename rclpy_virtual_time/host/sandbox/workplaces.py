"""The folder in which hosts work, as a file system of its own: the kernel decides what it holds.

The fork server mounts one over a folder that the judge has filled, in its own mount namespace. So
nobody else sees the mount, and it goes with the fork server and its hosts, however they end. The
judge gets a descriptor, and looks in through that.
"""

from __future__ import annotations

import os
import shutil
from pathlib import Path

from .amounts import MAX_FOLDER, MAX_FOLDER_FILES
from .users import mount, unmount

MS_NOSUID, MS_NODEV = 2, 4


def furnish(folder: Path, uid: int) -> int:
    """Put a file system of limited size over a folder, with what lies there now, for a user.

    Return a descriptor of the new folder. Needs own mounts.

    Raises OSError: the system refuses the mount; then the folder is as it was.
    """
    owner = uid or os.getuid()
    below = os.open(folder, os.O_PATH | os.O_DIRECTORY | os.O_NOFOLLOW)
    try:
        options = (
            f"mode=0700,size={MAX_FOLDER},nr_inodes={MAX_FOLDER_FILES},uid={owner},gid={owner}"
        )
        if owner == os.getuid():  # in a user namespace the group may be another
            options = options.replace(f"gid={owner}", f"gid={os.getgid()}")
        mount("tmpfs", str(folder), "tmpfs", MS_NOSUID | MS_NODEV, options)
        try:
            _copy(Path(f"/proc/self/fd/{below}"), folder, uid)
            return os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
        except BaseException:
            unmount(folder)
            raise
    finally:
        os.close(below)


def _copy(source: Path, folder: Path, uid: int) -> None:
    shutil.copytree(source, folder, symlinks=True, dirs_exist_ok=True)
    for path in (folder, *folder.rglob("*")) if uid else ():
        os.chown(path, uid, uid, follow_symlinks=False)
