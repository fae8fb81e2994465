"""nbgrader: its exchange, what `nbgrader collect` makes of it, its gradebook.

Sources, in jupyter/nbgrader:

- nbgrader/exchange/default/submit.py and collect.py: a folder `USER+ASSIGNMENT+TIMESTAMP`, perhaps
  with `+RANDOM`, in `inbound`; user names may hold `+`, so the parts are taken from the right.
  The folder's owner is whoever submitted; collect.py warns if that is not the user of the name.
  Collected work is `submitted/USER/ASSIGNMENT`, with its time in `timestamp.txt`.
"""

import os
import re
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

from grader.course.submission import read_regular_file
from grader.lms.folders import LITTER
from grader.lms.names import may_enter
from grader.lms.people import LOGIN
from grader.lms.platform import Entry, Platform, Read, SetAside, Who
from grader.lms.told import LONGEST, microseconds

_TIME = r"(?P<time>\d{4}-\d\d-\d\d \d\d:\d\d:\d\d(?:\.\d+)?(?: \w+)?)"
ATTEMPT = re.compile(rf"(?P<user>.+)\+(?P<assignment>[^+]+)\+{_TIME}(?:\+[\w-]+)?", re.DOTALL)
STRANGER = (
    "belongs to {}, not to {}, so a person has to say whose work it is; if it is right, grade a "
    "copy of the exchange that is your own (cp -r)"
)
SIDES = {
    "inbound": ("outbound", "feedback"),
    "submitted": ("source", "release", "autograded", "feedback", "gradebook.db"),
}


def read(folder: Path, paths: Sequence[Path]) -> Read:
    """Return each student's latest attempt at each assignment; older ones are set aside."""
    found = Read()
    names = {path.name for path in paths}
    folders = [path.name for path in paths if path.is_dir() and path.name not in LITTER]
    for path in paths:
        beside = {each for side in names.intersection(SIDES) for each in SIDES[side]}
        if path.name in beside:
            found.set_aside.append(SetAside(path.name, "a part of nbgrader's course", fault=False))
        elif path.is_symlink() or not path.is_dir():
            found.left.append(path)
        elif path.name in SIDES and (
            names.intersection(SIDES[path.name]) or (len(folders) == 1 and _is_part(path))
        ):
            _of_course(path, found)
        else:
            _attempt(path, found)
    return _latest(found)


def _is_part(path: Path) -> bool:
    """Return whether a folder is nbgrader's by what is in it; a student's may be called so, too."""
    try:
        inside = [each for each in path.iterdir() if each.is_dir()]
        if path.name == "inbound":
            return any(ATTEMPT.fullmatch(each.name) for each in inside)
        work = [each for one in inside for each in one.iterdir() if may_enter(each.name)]
        return bool(work) and all(each.is_dir() for each in work)
    except OSError:
        return False


def _of_course(path: Path, found: Read) -> None:
    for inner in sorted(path.iterdir()):
        if inner.is_symlink() or not inner.is_dir():
            found.set_aside.append(SetAside(f"{path.name}/{inner.name}", "no submission", False))
        elif path.name == "inbound":
            _attempt(inner, found)
        else:
            found.entries.extend(_collected(inner))


def _attempt(path: Path, found: Read) -> None:
    match = ATTEMPT.fullmatch(path.name)
    if match is None:
        found.left.append(path)
        return
    if owner := _stranger(path, match["user"]):
        found.set_aside.append(SetAside(path.name, STRANGER.format(owner, match["user"])))
        return
    who, time = Who(match["user"], PLATFORM, match["user"]), match["time"]
    found.entries.append(Entry(path, who, version=_microseconds(time), time=time))


def _stranger(path: Path, user: str) -> str:
    """Return the owner of a folder in the exchange who is not the student; "" if that is fine.

    Whoever can write into the exchange can make a folder that is called like a classmate's. In a
    copy all is the copier's, who is the one that grades, or root.
    """
    uid = path.lstat().st_uid
    if sys.platform == "win32" or uid in (0, os.geteuid()):
        return ""
    import pwd  # noqa: PLC0415  (not on Windows)

    try:
        name = pwd.getpwuid(uid).pw_name
    except KeyError:
        name = f"user {uid}"
    return "" if name == user else name


def _collected(student: Path) -> Iterator[Entry]:
    who = Who(student.name, PLATFORM, student.name)
    try:
        inside = sorted(student.iterdir())
    except OSError:
        yield Entry(student, who)  # it is held for that
        return
    for assignment in inside:
        if assignment.is_dir() and not assignment.is_symlink():
            time = _stamp(assignment / "timestamp.txt")
            yield Entry(assignment, who, version=_microseconds(time), time=time)


def _stamp(file: Path) -> str:
    try:
        return read_regular_file(file, LONGEST).decode("utf-8", "replace").strip()
    except OSError:
        return ""


def _microseconds(time: str) -> int:
    """Return a time of nbgrader's, which is UTC, as a number; 0 if it is none."""
    return microseconds(re.sub(r" [A-Z]+$", "", time))


def _latest(found: Read) -> Read:
    """Keep the latest attempt of each student at each assignment."""
    last: dict[tuple[str, str], Entry] = {}
    for entry in found.entries:
        match = ATTEMPT.fullmatch(entry.path.name)
        key = (entry.who.id, match["assignment"] if match else entry.path.name)
        if key not in last or last[key].version < entry.version:
            last[key] = entry
    kept = {id(entry) for entry in last.values()}
    found.set_aside.extend(
        SetAside(entry.path.name, "an older attempt; the latest counts", fault=False)
        for entry in found.entries
        if id(entry) not in kept
    )
    found.entries[:] = [entry for entry in found.entries if id(entry) in kept]
    return found


PLATFORM = Platform("nbgrader", "nbgrader", read, id_kind=LOGIN)
