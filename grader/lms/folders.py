"""Folders and archives: each is one student, and is called like them."""

import os
from collections.abc import Sequence
from pathlib import Path

from grader.lms.names import may_enter
from grader.lms.platform import Entry, Platform, Read, SetAside, Who
from grader.lms.unpack import archive_stem, is_archive, is_unread_archive

FILE = (
    "a file of nobody's: expected a folder or an archive per student, or files with the prefix of "
    "Canvas or Moodle; put it into its student's folder"
)
RESULTS = "results of `course autograde`, no student's; move them elsewhere"
GRADED_CLASS = ("store.sqlite", "class.html")
LITTER = {"Thumbs.db", "desktop.ini", "__MACOSX", "__pycache__"}


def read(folder: Path, paths: Sequence[Path]) -> Read:
    """Return every folder and archive; what else lies there is set aside."""
    found = Read()
    for path in sorted(paths, key=lambda path: (not path.is_dir(), path.name)):
        name = path.name
        if not may_enter(name) or name in LITTER:
            found.set_aside.append(SetAside(name, "no student's", fault=False))
        elif all(os.path.isfile(path / each) for each in GRADED_CLASS):  # noqa: PTH113
            found.set_aside.append(SetAside(name, RESULTS))
        elif path.is_dir() or is_archive(name) or is_unread_archive(name) or path.is_symlink():
            stem = name if path.is_dir() else archive_stem(name)
            found.entries.append(Entry(path, Who(stem, PLATFORM)))
        else:
            found.set_aside.append(SetAside(name, FILE))
    return found


PLATFORM = Platform("", "folder", read, key_of=lambda entry: entry.path.name)
