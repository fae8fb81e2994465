"""What a learning platform is to a class: its downloads, its lists of people, its gradebook."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import BinaryIO

from grader.lms.book import Book, Mark, Task


@dataclass(frozen=True)
class Who:
    """A student as a download names them."""

    name: str  # "leecarla", "Ann Lee", "bob"
    system: str  # the platform that read it: "canvas", "moodle", …
    id: str = ""  # the system's own id, unique in one download
    email: str = ""


def word_of(system: str, id_: str) -> str:
    """Return how a student of a platform is remembered; capitals don't count where it says so."""
    return f"{system}:{id_.casefold() if system in ('gradescope', 'github') else id_}"


@dataclass(frozen=True)
class Entry:
    """A file, folder or archive of a download, and whose it is."""

    path: Path
    who: Who
    called: str = ""  # what the student called it; "": what it is called now
    version: int = 0  # of two files with one name, the higher is newer
    late: bool = False  # says the platform
    time: str = ""  # when it was handed in, as the platform writes it

    @property
    def word(self) -> str:
        """What is the same for this student's entries in every download, and for no other's."""
        who = self.who
        known = {"folder": self.path.name, "gradescope": who.email or who.id or who.name}
        return word_of(who.system, known.get(who.system, who.id or who.name))


@dataclass(frozen=True)
class SetAside:
    """Something in a download that is not graded."""

    name: str  # where it lies in the download
    reason: str
    fault: bool = True  # a person should look; False for what is known to be of no interest


@dataclass(frozen=True)
class Read:
    """What a platform made of a download."""

    entries: list[Entry] = field(default_factory=list)
    set_aside: list[SetAside] = field(default_factory=list)
    left: list[Path] = field(default_factory=list)  # for the next platform
    # the ways to read a name that has several; a roster may know which is right
    unclear: list[list[Entry]] = field(default_factory=list)


Files = Mapping[str, str]  # path below the class's folder: content
Reads = Callable[[Path, Sequence[Path]], Read]
Fills = Callable[[Book, Sequence[Task]], Files]
Packs = Callable[[BinaryIO, Sequence[Mark], Task, Path], None]


@dataclass(frozen=True)
class Platform:
    """One platform; what it does not have is left out."""

    name: str  # "Canvas"
    # The entries among the paths of a folder. Nothing is opened or followed but the platform's own
    # files, and what it does not know is left for the next.
    read: Reads
    # The kind of a CSV with these headings, in small letters, if it is one of the platform's.
    sheet: Callable[[Sequence[str]], str] = lambda header: ""
    # The files that it imports; held gradings are in none.
    gradebook: Fills = lambda book, tasks: {}
    feedback: Packs | None = None  # writes a zip of the pages in a folder, as it takes them back
    folder: str = ""  # of its files; made anew each time
