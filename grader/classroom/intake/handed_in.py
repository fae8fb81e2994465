"""What students handed in, as it lies on this disk."""

from dataclasses import dataclass, field
from pathlib import Path

from grader.lms.people import Person
from grader.lms.platform import Entry, Who

WORK = (".py", ".pyw", ".py.txt")  # what may be an exercise under another name


@dataclass(frozen=True)
class HandedIn:
    """A file that somebody handed in."""

    path: Path  # where it lies, perhaps unpacked
    name: str  # what the student called it, with folders
    entry: Entry
    source: int = 0  # the download's place on the command line
    opened: bool = False  # a notebook saved as a program: what its cells write counts in its place

    @property
    def depth(self) -> int:
        """Folders above it in what the student handed in."""
        return self.name.count("/")

    @property
    def version(self) -> tuple[int, int]:
        """What makes one file newer than another of the same name."""
        return self.entry.version, self.source


@dataclass
class Student:
    """One who handed something in, or who is in the roster; or an entry of nobody's yet."""

    id: str  # a safe name for a folder
    person: Person | None = None  # in the roster
    entries: list[tuple[int, Entry]] = field(default_factory=list)  # theirs, with the downloads
    files: list[HandedIn] = field(default_factory=list)
    problems: list[str] = field(default_factory=list)  # why a part can't be read
    links: bool = False  # there are links, which are not followed
    whose: str = ""  # why nobody can tell whose it is; it is held then

    @property
    def problem(self) -> str:
        """Why a part can't be read; "" if all can."""
        return "; ".join(self.problems)

    @property
    def who(self) -> list[Who]:
        return [entry.who for _, entry in self.entries]
