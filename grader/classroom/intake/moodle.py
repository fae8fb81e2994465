"""Moodle's "Download all submissions": a folder per student, or flat files.

Source: moodle/moodle, mod/assign/classes/downloader.php (`get_student_prefix`,
`load_submissionplugin_filelist`): `FULLNAME_ID_assignsubmission_file`, with `_` in the name turned
into a space, then the student's folders and files, or `_FILENAME` if "Download submissions in
folders" is off; up to Moodle 4.0 a folder ended in `_`. The id is that of the participant in this
one assignment, the `Participant ID` of its grading worksheet. Group submissions are
`GROUP_ID_assignsubmission_file`.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

from grader.classroom.intake.entries import Entry, Read, Who

_WHO = r"(?P<name>[^_]+)_(?P<id>\d+)_assignsubmission_(?P<plugin>file|onlinetext)"
FOLDER = re.compile(rf"{_WHO}_?")
FLAT = re.compile(rf"{_WHO}_(?P<file>.+)", re.DOTALL)


def read(folder: Path, paths: Sequence[Path]) -> Read:
    """Return folders and files with Moodle's prefix."""
    found = Read()
    for path in paths:
        match = (FOLDER if path.is_dir() else FLAT).fullmatch(path.name)
        if match is None or path.is_symlink():
            found.left.append(path)
        else:
            called = "" if path.is_dir() else match["file"]
            found.entries.append(Entry(path, Who(match["name"], "moodle", match["id"]), called))
    return found
