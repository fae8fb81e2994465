"""What a learning platform is to a class: its downloads, its lists of people, its gradebook."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

from grader.lms.book import Book, Mark, Task
from grader.lms.entries import Read

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
    what: str = ""  # is in it
