"""Find submissions that are nearly the same as another's, an earlier year's or the course's code.

Programs are compared by their shapes (`shapes.py`). One that few programs here have counts for
more than one that many have: what honest programs share is what everybody writes. A match is a
reason to ask, never a proof.

Students have the checks, because their practice needs them. An oracle that is pasted into a node
passes local checks and the instructor's; it is not the student's work, which a person has to say.
"""

from __future__ import annotations

import functools
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import chain
from pathlib import PurePosixPath
from typing import TypeAlias

import msgspec
import numpy as np
from numpy.typing import NDArray

from grader.classroom.results.shapes import shapes, shapes_of
from grader.course.exercises import (
    EXERCISES,
    JUDGE,
    ROOT,
    SOLUTIONS,
    all_exercises,
    find_exercise,
)
from grader.link.cell import Refused, read_in_cell

SIMILAR = 0.55  # of the smaller one's weight; honest ones share at most 0.52 (docs/decisions.md)
PASTED = 0.35  # of a file's shapes that the checks have, too; of right solutions at most 0.12
FEW = 20  # shapes of one's own; a program with fewer is too short to compare
RARE = 3  # programs that have a shape; it counts for most
LINKS = 3  # shapes that bring two programs together; fewer are chance
CHECKS = ROOT / "grader" / "checks"
SHARED = (ROOT / "grader" / "models" / "features.py", ROOT / "grader" / "recording" / "views.py")
LISTING = re.compile(rb"^```\s*\{?(?:code-block\}\s*)?python\}?\n(.*?)^```", re.M | re.S)

# what `ros2 pkg create` writes, and what starts a package: everybody's are alike
MADE = re.compile(r"setup\.py|__init__\.py|test_\w+\.py|.*launch\.py")

Prints: TypeAlias = NDArray[np.int64]  # shapes, each once, in order
Sources: TypeAlias = Mapping[tuple[str, str], Mapping[str, bytes]]  # student, slug: files by name
Texts: TypeAlias = Mapping[str, Mapping[str, bytes]]  # whose: the compared files by name


class Pair(msgspec.Struct, frozen=True):
    """Two programs that are nearly the same."""

    left: str  # the student
    right: str  # another, one of an earlier year, or a file of the course's
    file: str
    similarity: float  # 0 … 1
    page: str = ""  # where both stand side by side, from the class report


class Group(msgspec.Struct, frozen=True):
    """Students whose files are nearly the same."""

    students: tuple[str, ...]
    pairs: tuple[Pair, ...]  # the closest ones that connect them all


class Alike(msgspec.Struct, frozen=True):
    """What comparing the submissions to one exercise came to."""

    count: int  # submissions
    groups: tuple[Group, ...] = ()
    taken: tuple[Pair, ...] = ()  # from an earlier year or the course
    unread: tuple[tuple[str, str], ...] = ()  # who is not compared, and why


def compared(texts: Texts, earlier: Texts, slug: str) -> Alike:
    """Compare the submissions to an exercise (`texts_of`), and earlier years' with them."""
    given, checks = given_shapes(slug), _checks(slug)
    every = np.unique(np.concatenate([given, *checks.values()]))
    mine, unread = _read(texts)
    old, _ = _read(earlier)
    course = {name: _prints(shapes(text)) for name, text in _solutions(slug).items()}
    within: list[Pair] = []
    taken: list[Pair] = []
    for file in sorted({name for files in mine.values() for name in files}):
        own = {who: files[file] for who, files in mine.items() if file in files}
        others = {who: files[file] for who, files in old.items() if file in files} | course
        prints = [np.setdiff1d(each, every) for each in (*own.values(), *others.values())]
        names = [*own, *others]
        found = [Pair(names[a], names[b], file, each) for each, a, b in _pairs(prints, len(own))]
        within += [pair for pair in found if pair.right in own]
        known = [pair for pair in reversed(found) if pair.right not in own]
        closest_of_each = {(pair.left, pair.right in course): pair for pair in known}
        taken += [*closest_of_each.values(), *_pasted(file, own, given, checks)]
    return Alike(len(texts), tuple(_groups(within)), tuple(closest(taken)), tuple(unread))


def texts_of(sources: Sources, slug: str) -> Texts:
    """Return what is compared of the submissions to an exercise."""
    names = find_exercise(slug).files
    return {who: parts_of(files, names) for (who, each), files in sources.items() if each == slug}


def parts_of(files: Mapping[str, bytes], names: Sequence[str]) -> dict[str, bytes]:
    """Return what is compared of a submission: the exercise's files (`names`).

    The first file counts with all modules that came along: where a node's parts lie, in which
    package, makes no difference. Other exercises' files are compared with theirs.
    """
    exercises = {name for exercise in all_exercises() for name in exercise.files}
    named = {PurePosixPath(place).name: files[place] for place in sorted(files)}
    parts = {name: named[name] for name in names if name in named}
    own = [t for name, t in named.items() if name not in exercises and not MADE.fullmatch(name)]
    if own:
        first = next(iter(parts), names[0])
        parts[first] = b"\n".join([*filter(None, [parts.get(first)]), *own])
    return parts


def closest(pairs: Iterable[Pair]) -> list[Pair]:
    return sorted(pairs, key=lambda pair: (-pair.similarity, pair.left, pair.right, pair.file))


def course_text(name: str) -> bytes:
    """Return a file of the course's that a pair names."""
    return (ROOT / name).read_bytes()


@functools.cache
def given_shapes(slug: str) -> Prints:
    """Return the shapes of what students are handed: skeletons, and listings in texts."""
    pages = [*(EXERCISES / slug).glob("*.md"), *(ROOT / "lessons").glob("*.md")]
    listings = [found for page in pages for found in LISTING.findall(page.read_bytes())]
    every = [file.read_bytes() for file in (EXERCISES / slug).glob("*.py")]
    for text in listings:
        try:
            shapes(text)
        except SyntaxError:  # lines of an output, or a part of a program
            continue
        every.append(text)
    return np.unique(_prints(chain.from_iterable(map(shapes, every))))


# --- what is read --------------------------------------------------------------------------------


def _read(texts: Texts) -> tuple[dict[str, dict[str, Prints]], list[tuple[str, str]]]:
    """Return the shapes of each student's files, read in the cell; and who can't be read, why."""
    found, unread = {}, []
    for who, files in texts.items():
        try:
            every = read_in_cell(shapes_of, list(files.values()), returns=list[list[int]])
            found[who] = {name: _prints(each) for name, each in zip(files, every, strict=True)}
        except Refused as error:
            unread.append((who, str(error)))
    return found, unread


def _prints(each: Iterable[int]) -> Prints:
    return np.fromiter(each, np.int64)


def _solutions(slug: str) -> dict[str, bytes]:
    files = sorted((SOLUTIONS / slug).rglob("*.py"))
    return {file.relative_to(ROOT).as_posix(): file.read_bytes() for file in files}


@functools.cache
def _checks(slug: str) -> dict[str, Prints]:
    files = [*CHECKS.glob("*.py"), *(JUDGE / slug).glob("*.py"), *SHARED]
    return {f.relative_to(ROOT).as_posix(): _prints(shapes(f.read_bytes())) for f in sorted(files)}


# --- what is compared ----------------------------------------------------------------------------


def _pairs(programs: Sequence[Prints], own: int) -> list[tuple[float, int, int]]:
    """Return the pairs that are SIMILAR, the closest first; the first `own` are the class.

    Only those are looked at that stand side by side among the holders of some shapes, and each with
    the last of them: so it takes time in proportion to what was handed in, a group of copies stays
    connected, and all of it meets an earlier year's.
    """
    count = len(programs)
    lengths = [len(each) for each in programs]
    owner = np.repeat(np.arange(count), lengths)
    _, which, holders = np.unique(np.concatenate(programs), return_inverse=True, return_counts=True)
    weights = np.log((count + 2) / np.maximum(holders, RARE))
    whole = np.bincount(owner, weights[which], count)
    ids = np.split(which, np.cumsum(lengths)[:-1])
    by_shape = np.lexsort((owner, which))
    shape, holder = which[by_shape], owner[by_shape]
    last = holder[np.cumsum(holders) - 1][shape]
    beside = np.append(holder[1:], 0)
    links = [
        (holder * count + other)[(other > holder) & same]
        for other, same in (
            (beside, np.append(shape[1:] == shape[:-1], False)),
            (last, last >= own),
        )
    ]
    met, times = np.unique(np.concatenate(links), return_counts=True)
    found = []
    for link in met[times >= LINKS]:
        a, b = divmod(int(link), count)
        if a < own and min(len(programs[a]), len(programs[b])) >= FEW:
            shared = weights[np.intersect1d(ids[a], ids[b], assume_unique=True)].sum()
            found.append((round(float(shared / min(whole[a], whole[b])), 3), a, b))
    return sorted((each for each in found if each[0] >= SIMILAR), reverse=True)


def _pasted(
    file: str, own: Mapping[str, Prints], given: Prints, checks: Mapping[str, Prints]
) -> Iterator[Pair]:
    """Return the programs that hold the checks' code, with the file that most of it is in."""
    every = np.unique(np.concatenate(list(checks.values())))
    for who, prints in own.items():
        mine = np.setdiff1d(prints, given)
        share = np.isin(mine, every).mean() if len(mine) >= FEW else 0.0
        if share >= PASTED:
            most = max(checks, key=lambda name: int(np.isin(mine, checks[name]).sum()))
            yield Pair(who, most, file, round(float(share), 3))


def _groups(pairs: Iterable[Pair]) -> list[Group]:
    """Return who belongs together, and the closest pairs that connect them (Kruskal's)."""
    groups: dict[str, tuple[set[str], list[Pair]]] = {}
    for pair in closest(pairs):
        left, right = (groups.setdefault(who, ({who}, [])) for who in (pair.left, pair.right))
        if left is not right:
            joined = left[0] | right[0], [*left[1], *right[1], pair]
            groups |= dict.fromkeys(joined[0], joined)
    every = {id(group): group for group in groups.values()}.values()
    made = [Group(tuple(sorted(members)), tuple(closest(inside))) for members, inside in every]
    return sorted(made, key=lambda group: (-group.pairs[0].similarity, group.students))
