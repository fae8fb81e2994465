"""What a download is made of: entries, whose they are, and what was set aside."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path


@dataclass(frozen=True)
class Who:
    """A student as a download names them."""

    name: str  # "leecarla", "Ann Lee", "bob"
    system: str  # the platform that read it: "canvas", "moodle", …
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
    """What a platform made of a download."""

    entries: list[Entry] = field(default_factory=list)
    set_aside: list[SetAside] = field(default_factory=list)
    left: list[Path] = field(default_factory=list)  # for the next platform
