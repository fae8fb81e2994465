"""Tell a platform's download of a class from one student's work: it may lie a folder too deep.

People keep downloads in folders, and name the folder above. What holds the work of several then
looks like a student. Only names are read, and it takes two people's to be sure: nobody else's
results depend on what a student calls a file.
"""

from __future__ import annotations

import os
import re
import zipfile
from collections.abc import Iterable
from pathlib import Path

from grader.classroom.intake import canvas, gradescope, moodle, nbgrader
from grader.classroom.intake.entries import is_clone
from grader.course.submission import open_regular_file

MANY = 2  # people


def platform_of(path: Path) -> str:
    """Return whose download of several students' work a folder or a zip is; "" if it is none."""
    names = _names(path)
    if gradescope.METADATA in names:
        return "Gradescope"
    if len(_matched(names, moodle.FOLDER, moodle.FLAT)) >= MANY:
        return "Moodle"
    if len(_matched(names, canvas.UPLOAD)) >= MANY:
        return "Canvas"
    if len(_matched(names, nbgrader.ATTEMPT, group="user")) >= MANY:
        return "nbgrader"
    if path.is_dir() and sum(is_clone(path / name) for name in names) >= MANY:
        return "GitHub Classroom"
    return ""


def _names(path: Path) -> list[str]:
    """Return what lies in a folder or a zip, or in the one folder that holds all of it."""
    try:
        if path.is_dir():
            return sorted(os.listdir(path))  # noqa: PTH208
        if not path.name.lower().endswith(".zip"):
            return []
        with open_regular_file(path) as file, zipfile.ZipFile(file) as opened:
            parts = [name.replace("\\", "/").split("/") for name in opened.namelist()]
    except Exception:  # a broken archive is told of when it is unpacked
        return []
    if len({each[0] for each in parts}) == 1:
        parts = [each[1:] for each in parts]
    return sorted({each[0] for each in parts if each and each[0]})


def _matched(names: Iterable[str], *patterns: re.Pattern[str], group: str = "id") -> set[str]:
    """Return the different people whose prefix the names have."""
    found = (pattern.fullmatch(name) for name in names for pattern in patterns)
    return {match[group] for match in found if match is not None}
