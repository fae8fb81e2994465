"""What a download is made of: entries, whose they are, and what was set aside."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol

from grader.classroom.roster import Person


@dataclass(frozen=True)
class Who:
    """A student as a download names them."""

    name: str  # "leecarla", "Ann Lee", "bob"
    system: str  # the layout that read it: "canvas", "moodle", …
    id: str = ""  # the system's own id, unique in one download
    email: str = ""


@dataclass(frozen=True)
class Entry:
    """A file, folder or archive of a download, and whose it is."""

    path: Path
    who: Who
    called: str = ""  # what the student called it; "": what it is called now
    version: int = 0  # of two files with one name, the higher is newer
    late: bool = False  # says the platform
    time: str = ""  # when it was handed in, as the platform writes it


@dataclass(frozen=True)
class SetAside:
    """Something in a download that is not graded."""

    name: str  # where it lies in the download
    reason: str
    fault: bool = True  # a person should look; False for what is known to be of no interest


@dataclass(frozen=True)
class Read:
    """What a layout made of a download."""

    entries: list[Entry] = field(default_factory=list)
    set_aside: list[SetAside] = field(default_factory=list)
    left: list[Path] = field(default_factory=list)  # for the next layout


class Layout(Protocol):
    """Reads one kind of download; what it does not know is left for the next."""

    def __call__(self, folder: Path, paths: Sequence[Path]) -> Read:
        """Return the entries among `paths`, which lie in `folder`; nothing is opened or followed.

        Only the platform's own files may be read.
        """


@dataclass(frozen=True)
class HandedIn:
    """A file that somebody handed in."""

    path: Path  # where it lies, perhaps unpacked
    name: str  # what the student called it, with folders
    entry: Entry
    source: int = 0  # the download's place on the command line

    @property
    def depth(self) -> int:
        """Folders above it in what the student handed in."""
        return self.name.count("/")

    @property
    def version(self) -> tuple[int, int]:
        """What makes one file newer than another of the same name."""
        return self.entry.version, self.source


def is_clone(path: Path) -> bool:
    """Tell whether a folder is a repository, as far as it can be read."""
    return not path.is_symlink() and path.is_dir() and os.path.exists(path / ".git")  # noqa: PTH110


@dataclass(frozen=True)
class Student:
    """One who handed something in, or who is in the roster."""

    id: str  # a safe name for a folder
    files: tuple[HandedIn, ...] = ()
    problem: str = ""  # why a part can't be read; "" if all can
    links: bool = False  # there are links, which are not followed
    person: Person | None = None  # in the roster
    who: tuple[Who, ...] = ()
    entries: tuple[str, ...] = ()  # what of the downloads is theirs
