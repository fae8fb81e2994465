"""Learning platforms, one file each: what they hand over, and what they take back.

Nothing that is read here is trusted: an archive may be broken, locked, a bomb or a trap, a folder
may hold links to the instructor's files, and names are whatever students typed. A new platform is a
file with a `PLATFORM`, and a word in `PLATFORMS`.
"""

from __future__ import annotations

import os
import zipfile
from pathlib import Path

from grader.course.submission import open_regular_file
from grader.lms import canvas, folders, github, gradescope, moodle, nbgrader
from grader.lms.platform import Platform

# Each leaves what it does not know for the next; the last takes the rest.
PLATFORMS: tuple[Platform, ...] = (
    gradescope.PLATFORM, nbgrader.PLATFORM, moodle.PLATFORM, canvas.PLATFORM, github.PLATFORM,
    folders.PLATFORM,
)  # fmt: skip
TIMES = (*moodle.TIMES, *folders.TIMES)  # how times are written, but for ISO 8601

__all__ = ["PLATFORMS", "TIMES", "Platform", "platform_of"]


def platform_of(path: Path) -> str:
    """Return whose download of several students' work a folder or a zip is; "" if it is none.

    People keep downloads in folders, and name the folder above. What holds the work of several then
    looks like a student. Only names are read, and it takes two people's to be sure: nobody else's
    results depend on what a student calls a file.
    """
    names = _names(path)
    return next((each.name for each in PLATFORMS if each.is_download(names)), "")


def _names(path: Path) -> list[str]:
    """Return what lies in a folder or a zip, or in the one folder that holds all of it.

    A repository is called `NAME/.git`.
    """
    try:
        if path.is_dir():
            return sorted(
                f"{each}/.git" if github.is_clone(path / each) else each
                for each in os.listdir(path)  # noqa: PTH208
            )
        if not path.name.lower().endswith(".zip"):
            return []
        with open_regular_file(path) as file, zipfile.ZipFile(file) as opened:
            parts = [name.replace("\\", "/").split("/") for name in opened.namelist()]
    except Exception:  # a broken archive is reported when it is unpacked
        return []
    if len({each[0] for each in parts}) == 1:
        parts = [each[1:] for each in parts]
    return sorted({each[0] for each in parts if each and each[0]})
