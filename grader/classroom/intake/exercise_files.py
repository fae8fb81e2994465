"""Find an exercise's files among a student's, and say what is left over."""

import contextlib
import difflib
import hashlib
import re
from collections.abc import Collection, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path, PurePosixPath

from grader.classroom.intake.handed_in import WORK, HandedIn, Student
from grader.classroom.intake.skeletons import is_empty, is_handed_out, is_skeleton, skeletons
from grader.course.beside import MANIFEST, MAX_BYTES, PYTHON, Lying
from grader.course.beside import chosen as chosen_of
from grader.course.submission import SETUPS, read_regular_file
from grader.lms.names import copy_number, plain, uncopied
from grader.lms.platform import Entry
from grader.lms.unpack import is_archive, is_unread_archive

NOTEBOOKS = (".ipynb", ".py", ".pyw", ".txt")  # of what is no file, but its cells' files are
SOLE = "the only file that may be work"
NEAR = "taken for {}, since no other file has a name like it"
ENOUGH = 0.88  # of `_nearness`; two files of the course's are at most 0.83 near
PART = 0.75  # of a name's letters; an exercise's own has as many of its file's
IMPORTED = re.compile(rb"^[ \t]*(?:from|import)\b[^\n(]*(?:\([^)]*\))?", re.MULTILINE)


@dataclass(frozen=True)
class Found:
    """The files of one exercise that a student handed in, by the names the exercise gives them."""

    files: dict[str, Path]
    problem: str = ""  # why nothing can be graded; "" if it can
    older: tuple[HandedIn, ...] = ()  # versions that do not count
    used: tuple[HandedIn, ...] = field(default=(), repr=False)
    contrary: tuple[HandedIn, ...] = ()  # of `older`: another work, from another download
    beside: dict[str, HandedIn] = field(default_factory=dict, repr=False)  # comes along, by place
    untouched: tuple[HandedIn, ...] = ()  # as they were handed out
    why: str = ""  # a file of another name counts; "" if it has the right one

    @property
    def python(self) -> dict[str, Path]:
        """The student's Python by its place: the exercise's files, and what comes along."""
        more = {name: file.path for name, file in self.beside.items() if name.endswith(PYTHON)}
        return {**more, **self.files}

    @property
    def every(self) -> dict[str, Path]:
        """All that is graded together, by its place."""
        return {**{name: file.path for name, file in self.beside.items()}, **self.files}

    @property
    def needed(self) -> list[HandedIn]:
        """What comes along and is certainly of this work: a package's files, imported modules."""
        if MANIFEST in self.beside:
            return list(self.beside.values())
        names: set[bytes] = set()
        for path in self.python.values():
            with contextlib.suppress(OSError):
                for line in IMPORTED.findall(read_regular_file(path)):
                    names.update(re.findall(rb"\w+", line))
        modules = {name: PurePosixPath(name.removesuffix("/__init__.py")) for name in self.beside}
        return [self.beside[name] for name, at in modules.items() if at.stem.encode() in names]

    @property
    def entry(self) -> Entry | None:
        """The entry of the download that the graded file came in."""
        return self.used[0].entry if self.used else None


def find_files(student: Student, names: Sequence[str], taken: str = "", why: str = "") -> Found:
    """Return a student's files called `names`; the first one is required.

    What still is the skeleton was not handed in, unless another of the files is work. Of several
    the newest counts: what the platform received last; else the one nearest to the top, and there
    the highest number of a copy. Names may differ in case, and may have the suffix that a browser
    gives a second copy. If none has the right name, the only one that is near to it counts. Before
    all counts the file `taken` (a `HandedIn.name`), and `why` says so.
    """
    first, *others = names
    versions, why = _versions(student, first, taken, why)
    untouched = [file for file in _called(first, student.files) if is_skeleton(file.path, first)]
    if not versions and any(_changed(other, student.files) for other in others):
        versions, untouched = untouched, []
    if not versions:
        return Found({}, _missing(student, first, untouched), untouched=tuple(untouched))
    used, older = _together(student, versions, names)
    files = {name: file.path for name, file in used.items()}
    along, in_package = _beside(student, versions[0], {*used.values(), *older})
    if in_package:  # its files lie where it has them
        placed = {file.path: name for name, file in along.items()}
        files = {placed.get(path, name): path for name, path in files.items()}
    return Found(
        files, "", tuple(older), tuple(used.values()), _contrary(versions), along,
        tuple(untouched), why,
    )  # fmt: skip


def _versions(
    student: Student, first: str, taken: str, why: str
) -> tuple[list[HandedIn], str]:  # fmt: skip
    """Return the versions of the required file, and why it may have another name.

    They are the file `taken` and its copies, else the work of the right name, else the only file
    of a near name.
    """
    wanted = PurePosixPath(taken)
    accepted = [
        file for file in _called(wanted.name, student.files)
        if taken and PurePosixPath(file.name).parent == wanted.parent
    ]  # fmt: skip
    if accepted:
        return accepted, why
    if work := [file for file in _changed(first, student.files) if not is_empty(file.path)]:
        return work, ""
    near = _near(first, student.files)
    return (near, NEAR.format(first)) if len(near) == 1 else ([], "")


def _changed(name: str, files: Sequence[HandedIn]) -> list[HandedIn]:
    """Return the files of that name that are not the skeleton."""
    return [file for file in _called(name, files) if not is_skeleton(file.path, name)]


def _missing(student: Student, first: str, untouched: Sequence[HandedIn]) -> str:
    """Say why there is no version of the required file."""
    if student.problem:
        return student.problem
    if untouched:
        return f"{first} is still the skeleton"
    if empty := [file for file in _called(first, student.files) if is_empty(file.path)]:
        return f"{empty[0].name} is empty; another copy is needed"
    return f"expected a file {first}; {_inventory(student)}"


def _together(
    student: Student, versions: Sequence[HandedIn], names: Sequence[str]
) -> tuple[dict[str, HandedIn], list[HandedIn]]:
    """Return the newest version with the exercise's other files, by name, and what is older."""
    (first, *others), (chosen, *older) = names, versions
    used = {first: chosen}
    for other in others:
        same = sorted(_called(other, student.files), key=lambda file: is_skeleton(file.path, other))
        beside = [file for file in same if file.path.parent == chosen.path.parent]
        if same:
            used[other] = (beside or same)[0]
            older += [file for file in same if file is not used[other]]
    return used, older


def _contrary(versions: Sequence[HandedIn]) -> tuple[HandedIn, ...]:
    """Return the versions that are another work than the newest, from another download."""
    chosen, mine = versions[0], _content(versions[0].path)
    others = (file for file in versions if file.source != chosen.source)
    return tuple(file for file in others if _content(file.path) != mine)


def find_sole(student: Student, names: Sequence[str]) -> Found:
    """Do as `find_files`, but take the only file that may be work, whatever it is called.

    What was handed out is no work.
    """
    files = [each for each in left_over(student, ()) if not is_handed_out(each.path)]
    sole = files[0].name if len(files) == 1 and _is_python(files[0]) else ""
    return find_files(student, names, sole, SOLE)


def _is_python(file: HandedIn) -> bool:
    return file.name.lower().endswith(WORK) and not file.opened


def _near(name: str, files: Sequence[HandedIn]) -> list[HandedIn]:
    """Return the work that is called nearly so, and nearer than any other exercise's file."""
    found = []
    for file in files:
        nearness = {each: _nearness(each, _base(file)) for each in skeletons()}
        best = max(nearness.values(), default=0.0)
        right = best >= ENOUGH and nearness.get(name, 0.0) == best
        if right and _is_python(file) and not is_handed_out(file.path):
            found.append(file)
    return found


@lru_cache(100_000)
def _nearness(name: str, other: str) -> float:
    """Return from 0 to 1 how near a file's name is to the right one; only letters count."""
    right, mine = _letters(name), _letters(other)
    if right in mine:
        return 1.0
    if mine in right and len(mine) >= PART * len(right):
        return ENOUGH
    return difflib.SequenceMatcher(None, right, mine).ratio()


def _letters(name: str) -> str:
    stem = name.casefold().removesuffix(".txt").removesuffix(".pyw").removesuffix(".py")
    return re.sub(r"[^a-z]", "", stem)


def _beside(
    student: Student, node: HandedIn, used: Collection[HandedIn]
) -> tuple[dict[str, HandedIn], bool]:
    """Return what comes along with a node, by its place in its folder; and if that is a package's.

    Of several files with one place the newest counts; a module's is its name without what a
    platform adds to a second copy, and other files have both names.
    """
    together = [file for file in student.files if _came_with(file, node)]
    folder, in_package = _root(PurePosixPath(node.name), {file.name for file in together})
    folders = [folder]
    if folder.suffix in NOTEBOOKS:  # a cell wrote it: what lies beside that comes, too
        folders.append(folder.parent)
    found: dict[str, HandedIn] = {}
    copies: dict[str, HandedIn] = {}
    for each in folders:
        for file in sorted(together, key=_age):
            name = PurePosixPath(file.name)
            if name.is_relative_to(each) and (in_package or file not in used):
                place = name.relative_to(each)
                inside = any(above.suffix in NOTEBOOKS for above in place.parents)
                if file.opened or name == each or inside:
                    continue  # of a notebook's cells, which are not this node's
                if file.path == file.entry.path:
                    single = place.with_name(uncopied(place.name))
                    place = single if place.suffix == ".py" else place
                    copies.setdefault(single.as_posix(), file)
                found.setdefault(place.as_posix(), file)
    found = {**copies, **found}
    sizes = (Lying(name, file.path, _size(file.path)) for name, file in found.items())
    return {name: found[name] for name in chosen_of(sizes).files}, in_package


def _came_with(file: HandedIn, node: HandedIn) -> bool:
    """Return whether two files were handed in together: in one folder or archive, or one by one."""
    alone = file.path == file.entry.path and node.path == node.entry.path
    return file.source == node.source and (file.entry is node.entry or alone)


def _root(node: PurePosixPath, names: Collection[str]) -> tuple[PurePosixPath, bool]:
    """Return the folder of a node, or of the package of which it is a module; and whether it is."""
    folder = node.parent
    while str(folder) != "." and f"{folder}/__init__.py" in names:
        folder = folder.parent
    near = [folder, folder.parent]
    if folder == node.parent:  # a package's modules need no __init__.py if setup.py names it
        near = [folder.parent] if folder.name and folder.suffix not in NOTEBOOKS else []
    for each in near:
        there = [name for name in (MANIFEST, *SETUPS) if (each / name).as_posix() in names]
        if there[:1] == [MANIFEST] and len(there) > 1:
            return each, True
    return node.parent, False


def _size(path: Path) -> int:
    try:
        return path.lstat().st_size
    except OSError:
        return MAX_BYTES + 1


def left_over(student: Student, used: Collection[HandedIn]) -> list[HandedIn]:
    """Return the files that may be work under another name: Python, archives."""
    known = set(used)
    return [
        file for file in student.files
        if file not in known
        and (_is_python(file) or is_archive(file.name) or is_unread_archive(file.name))
    ]  # fmt: skip


def _called(name: str, files: Sequence[HandedIn]) -> list[HandedIn]:
    """Return the files of that name, the one that counts first."""
    same = [file for file in files if plain(_base(file)) == plain(name) and not file.opened]
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
        text += " (archives deeper inside are not unpacked)"
    if any(file.opened or file.name.lower().endswith(".ipynb") for file in files):
        text += " (no %%node cell of a notebook writes it, or it is still the skeleton)"
    return text + links


def _content(path: Path) -> bytes:
    try:
        return hashlib.sha256(read_regular_file(path)).digest()
    except OSError:
        return b""
