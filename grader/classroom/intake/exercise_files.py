"""Find an exercise's files among a student's, and say what is left over."""

from __future__ import annotations

import hashlib
from collections.abc import Collection, Sequence
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath

from grader.classroom.intake.handed_in import HandedIn, Student
from grader.course.submission import read_regular_file
from grader.lms.names import copy_number, plain
from grader.lms.platform import Entry
from grader.lms.unpack import is_archive, is_unread_archive

WORK = (".py", ".pyw", ".py.txt")  # what may be an exercise under another name


@dataclass(frozen=True)
class Found:
    """The files of one exercise that a student handed in, by the names the exercise gives them."""

    files: dict[str, Path]
    problem: str = ""  # why nothing can be graded; "" if it can
    older: tuple[HandedIn, ...] = ()  # versions that do not count
    used: tuple[HandedIn, ...] = field(default=(), repr=False)
    contrary: tuple[HandedIn, ...] = ()  # of `older`: another work, from another download

    @property
    def entry(self) -> Entry | None:
        """The entry of the download that the graded file came in."""
        return self.used[0].entry if self.used else None


def find_files(student: Student, names: Sequence[str]) -> Found:
    """Return a student's files called `names`; the first one is required.

    Of several the newest counts: what the platform received last; else the one nearest to the top,
    and there the highest number of a copy. Names may differ in case, and may have the suffix that a
    browser gives a second copy.
    """
    first, *others = names
    candidates = _called(first, student.files)
    if not candidates:
        problem = student.problem or f"expected a file {first}; {_inventory(student)}"
        return Found({}, problem)
    chosen = candidates[0]
    used = [chosen]
    found = {first: chosen.path}
    older = list(candidates[1:])
    for other in others:
        same = _called(other, student.files)
        beside = [file for file in same if file.path.parent == chosen.path.parent]
        if same:
            used.append((beside or same)[0])
            found[other] = used[-1].path
            older += [file for file in same if file is not used[-1]]
    mine = _content(chosen.path)
    contrary = [
        file for file in candidates if file.source != chosen.source and _content(file.path) != mine
    ]
    return Found(found, older=tuple(older), used=tuple(used), contrary=tuple(contrary))


def left_over(student: Student, used: Collection[HandedIn]) -> list[HandedIn]:
    """Return the files that may be work under another name: Python, notebooks, archives."""
    known = {id(file) for file in used}
    return [file for file in student.files if id(file) not in known and _may_be_work(file.name)]


def _may_be_work(name: str) -> bool:
    return name.lower().endswith(WORK) or is_archive(name) or is_unread_archive(name)


def _called(name: str, files: Sequence[HandedIn]) -> list[HandedIn]:
    """Return the files of that name, the one that counts first."""
    same = [file for file in files if plain(_base(file)) == plain(name)]
    return sorted(same, key=lambda file: (*_age(file), _base(file) != name, file.name))


def _age(file: HandedIn) -> tuple[int, int, int, int]:
    version, source = file.version
    return -version, -source, file.depth, -copy_number(_base(file))


def _base(file: HandedIn) -> str:
    return PurePosixPath(file.name).name


def _inventory(student: Student) -> str:
    files, links = student.files, " (links are not followed)" if student.links else ""
    if not files:
        return f"there are no files{links}"
    names = [file.name for file in sorted(files, key=lambda file: (file.depth, file.name))]
    python = [name for name in names if name.lower().endswith(".py")] or names
    shown = ", ".join(ascii(name)[1:-1] if not name.isprintable() else name for name in python[:5])
    text = f"there is {shown}" + (" and more" if len(python) > 5 else "")
    if any(map(is_archive, names)):
        text += " (archives inside are not unpacked)"
    if any(name.lower().endswith(".ipynb") for name in names):
        text += " (no %%node cell of a notebook writes it, or it is still the skeleton)"
    return text + links


def _content(path: Path) -> bytes:
    try:
        return hashlib.sha256(read_regular_file(path)).digest()
    except OSError:
        return b""
