"""A page for each pair of programs that are nearly the same: both, and what matches."""

from __future__ import annotations

import re
import shutil
from collections.abc import Collection, Iterator, Mapping, Sequence
from itertools import groupby
from pathlib import Path
from typing import NamedTuple

from msgspec.structs import replace

from grader.classroom.results import similarity
from grader.classroom.results.files import write_text
from grader.classroom.results.page import render
from grader.classroom.results.shapes import Statement, statements
from grader.course.exercises import find_exercise
from grader.link.cell import Refused, read_in_cell

LIKENESS = "likeness"  # the folder
MOST_PAGES = 200  # of an exercise, of the most similar pairs
MOST_PLACES = 20  # of a statement in the other file that are tried
AROUND = 4  # lines beside what matches
MOST_LINES = 2_000  # of a file on a page
LONGEST = 240  # [characters] of a line on a page
COLOURS = 6
LINE_END = re.compile("\r\n?|\n")  # as Python counts lines


class Line(NamedTuple):
    """A line of a program on the page."""

    number: int
    text: str
    passage: int  # 0: nothing in the other file is like it
    first: bool  # of its passage


class Gap(NamedTuple):
    """Lines that are left out."""

    lines: int


def write_likeness(
    out: Path, sources: similarity.Sources, earlier: similarity.Sources, title: str
) -> dict[str, similarity.Alike]:  # fmt: skip
    """Compare the submissions to each exercise, write the pages of pairs, return what came of it.

    Both map (student, slug) to files; `earlier` are those of earlier years.
    """
    shutil.rmtree(out / LIKENESS, ignore_errors=True)
    found = {}
    for slug in sorted({slug for _, slug in sources}):
        mine, old = similarity.texts_of(sources, slug), similarity.texts_of(earlier, slug)
        alike = similarity.compared(mine, old, slug)
        given = frozenset(similarity.given_shapes(slug).tolist())
        every = [*alike.taken, *(pair for group in alike.groups for pair in group.pairs)]
        pages = {}
        for number, pair in enumerate(similarity.closest(every)[:MOST_PAGES], 1):
            pages[pair] = replace(pair, page=f"{LIKENESS}/{slug}/{number}.html")
            both = [_text(who, pair.file, {**mine, **old}) for who in (pair.left, pair.right)]
            write_text(out / pages[pair].page, _page(pair, slug, both, given, title))
        groups = (
            replace(group, pairs=tuple(pages.get(pair, pair) for pair in group.pairs))
            for group in alike.groups
        )
        taken = tuple(pages.get(pair, pair) for pair in alike.taken)
        found[slug] = replace(alike, groups=tuple(groups), taken=taken)
    return found


def passages(
    left: Sequence[Statement], right: Sequence[Statement], given: Collection[int] = ()
) -> Iterator[tuple[int, int, int]]:
    """Return runs of the same statements: where they begin on each side, and how many they are.

    From the first statement on the left, each time the longest run that is left over on the right.
    Runs of nothing but `given` statements are left out.
    """
    places: dict[int, list[int]] = {}
    for place, (shape, *_) in enumerate(right):
        places.setdefault(shape, []).append(place)
    taken, at = set[int](), 0
    while at < len(left):
        found = (0, 0)
        for place in places.get(left[at][0], ())[:MOST_PLACES]:
            length = 0
            while (
                at + length < len(left)
                and place + length < len(right)
                and place + length not in taken
                and left[at + length][0] == right[place + length][0]
            ):
                length += 1
            found = max(found, (length, place), key=lambda run: run[0])
        length, place = found
        run = {shape for shape, *_ in left[at : at + length]}
        if length > 1 and not run.issubset(given):
            taken |= set(range(place, place + length))
            yield at, place, length
        at += max(length, 1)


def _text(who: str, file: str, texts: similarity.Texts) -> bytes:
    return texts[who][file] if who in texts else similarity.course_text(who)


def _page(
    pair: similarity.Pair, slug: str, both: Sequence[bytes], given: Collection[int], title: str
) -> str:  # fmt: skip
    try:
        left, right = read_in_cell(statements, both, returns=list[list[Statement]])
    except Refused:  # it was read before: the machine is busy
        left, right = [], []
    marks: tuple[dict[int, int], dict[int, int]] = ({}, {})
    runs = list(passages(left, right, given))
    for number, (*begins, length) in enumerate(runs, 1):
        for side, heads, begin in zip(marks, (left, right), begins, strict=True):
            lines = range(heads[begin][1], heads[begin + length - 1][2] + 1)
            side.update(dict.fromkeys(lines, number))
    sides = [
        (who, list(_shown(text, side)))
        for who, text, side in zip((pair.left, pair.right), both, marks, strict=True)
    ]
    return render(
        "pair.html", f"{pair.left} and {pair.right}: {title}", pair=pair, sides=sides,
        task=find_exercise(slug), count=len(runs), colours=COLOURS,
    )  # fmt: skip


def _shown(text: bytes, marks: Mapping[int, int]) -> Iterator[Line | Gap]:
    """Return a program's lines; of long stretches that match nothing, the first and last ones."""
    lines = LINE_END.split(text.decode("utf-8", "replace"))
    before, left = 0, MOST_LINES
    numbers = range(1, len(lines) + 1)
    near = {near for line in marks for near in range(line - AROUND, line + AROUND + 1)}
    for is_near, group in groupby(numbers, key=lambda number: number in near):
        stretch = list(group)
        if left <= 0 or (not is_near and len(stretch) > 10 * AROUND):
            yield Gap(len(stretch))
            continue
        for number in stretch[:left]:
            mark = marks.get(number, 0)
            yield Line(number, lines[number - 1][:LONGEST], mark, mark not in (0, before))
            before = mark
        if len(stretch) > left:
            yield Gap(len(stretch) - left)
        left -= len(stretch)
