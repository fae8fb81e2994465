"""Similar submissions: what the class report calls alike, and what it doesn't."""

from __future__ import annotations

import functools
import random
from pathlib import Path

import numpy as np
import pytest
from edited import edited, edits
from made_results import OBSTACLES

from grader.classroom.results import similarity
from grader.classroom.results.pair_pages import passages, write_likeness
from grader.classroom.results.shapes import MOST, shapes, shapes_of, statements
from grader.classroom.results.similarity import Alike, compared
from grader.course.exercises import Exercise, all_exercises, find_exercise

EXERCISES = pytest.mark.parametrize("exercise", all_exercises(), ids=lambda each: each.slug)
ESCAPES = {"all": 15}  # of 60 copies
EDITS = list(edits())
FILE = f"{OBSTACLES}_agent.py"
RELATED = "loader_functions"  # shares the code around a model's file with the reference


@functools.cache
def honest(slug: str) -> dict[str, bytes]:
    """Independent solutions of an exercise: the reference and its variants."""
    folder = find_exercise(slug).solutions
    return {
        path.relative_to(folder).with_suffix("").as_posix(): path.read_bytes()
        for path in sorted(folder.rglob("*.py"))
        if path.stem != RELATED
    }


@functools.cache
def is_short(source: bytes, slug: str) -> bool:
    """Tell whether too little of a program is its author's."""
    theirs = [similarity.given_shapes(slug), *similarity._checks(slug).values()]
    return len(np.setdiff1d(shapes(source), np.concatenate(theirs))) < similarity.FEW


@functools.cache
def read_here(sources: tuple[bytes, ...]) -> list[list[int]]:
    return shapes_of(sources)


@pytest.fixture
def without_cells(monkeypatch: pytest.MonkeyPatch) -> None:
    """Read in this process, because thousands of programs are read."""
    monkeypatch.setattr(
        similarity, "read_in_cell", lambda work, files, **_: read_here(tuple(files))
    )


def alike(texts: dict[str, bytes], slug: str, earlier: dict[str, bytes] | None = None) -> Alike:
    file = find_exercise(slug).files[0]
    every = [{who: {file: text} for who, text in each.items()} for each in (texts, earlier or {})]
    return compared(*every, slug)


@pytest.fixture(autouse=True)
def without_solutions(monkeypatch: pytest.MonkeyPatch) -> None:
    """Here the course's solutions are the students'."""
    monkeypatch.setattr(similarity, "SOLUTIONS", Path("nowhere"))


@EXERCISES
def test_independent_solutions_are_not_similar(exercise: Exercise) -> None:
    found = alike(honest(exercise.slug), exercise.slug)
    assert found.groups == found.taken == found.unread == ()


@pytest.mark.usefixtures("without_cells")
@pytest.mark.parametrize(("edit", "made"), EDITS, ids=[name for name, _ in EDITS])
def test_a_copy_is_told_after_edits(edit: str, made: tuple) -> None:
    """One copies each solution in turn: who gets away? Nobody else is suspected."""
    missed = []
    for slug, theirs in ((each.slug, honest(each.slug)) for each in all_exercises()):
        for victim, source in theirs.items():
            found = alike(theirs | {"copy": edited(source, made, victim)}, slug)
            groups = [group.students for group in found.groups]
            assert groups in ([], [tuple(sorted(["copy", victim]))])
            missed += [(slug, victim)] * (not groups and not is_short(source, slug))
    assert len(missed) <= ESCAPES.get(edit, 0), missed


def test_what_is_handed_out_is_no_similarity() -> None:
    """Two who have done little have the skeleton in common, and nothing else."""
    skeleton = (find_exercise(OBSTACLES).folder / FILE).read_bytes()
    done = skeleton.replace(b"def stop(", b"def first(self):\n        return 1\n\n    def stop(")
    assert done != skeleton
    assert alike({"ann": done, "ben": done.replace(b"1", b"2")}, OBSTACLES).groups == ()


def test_earlier_years_are_matched_and_not_reported() -> None:
    """Two of last year's are the same: nobody hears of it, but of who has copied one of them."""
    *others, (_, source) = honest(OBSTACLES).items()
    mine = dict(others) | {"ann": edited(source, dict(EDITS)["flow"], "")}
    found = alike(mine, OBSTACLES, {"2025/x": source, "2025/y": source})
    assert found.groups == ()
    (pair,) = found.taken
    assert (pair.left, pair.right[:5]) == ("ann", "2025/")


def test_a_ring_is_one_group() -> None:
    others = honest(OBSTACLES)
    source = others[f"{OBSTACLES}_agent"]
    ring = {f"r{n}": edited(source, made, str(n)) for n, (_, made) in enumerate(EDITS)}
    (group,) = alike(others | ring, OBSTACLES).groups
    assert set(group.students) == {*ring, f"{OBSTACLES}_agent"}
    assert len(group.pairs) == len(ring)


def test_noise_hides_no_copy_and_too_much_is_said() -> None:
    chance = random.Random(1)
    source = honest(OBSTACLES)["variants/compact"]
    noise = b"".join(
        f"a = b {chance.choice('+-*/%@')} c {chance.choice('+-*/%@')} d\n".encode()
        for _ in range(9_000)
    )
    (group,) = alike(honest(OBSTACLES) | {"ann": noise + source}, OBSTACLES).groups
    assert group.students == ("ann", "variants/compact")

    words = ("x", "1", "x + y", "x[1]", "-x")
    much = b"".join(
        f"f({', '.join(chance.choice(words) for _ in range(9))})\n".encode() for _ in range(MOST)
    )
    ((who, why),) = alike({"ann": much + source, "ben": source}, OBSTACLES).unread
    assert who == "ann"
    assert f"{MOST:,}" in why


@pytest.mark.parametrize(
    "source",
    [
        b"\x00\xff", b"def (", b"\tif x:\n  y", b"# coding: rot13\nx",
        b"# coding: utf-16\nx = 1\n", b"# coding: unicode_escape\nx = '\\", b"(" * 2**20,
        b"-" * 2**19 + b"1", b"x." * 2**19 + b"x", b'"""\n' * 2**18 + b'"',
    ],
)  # fmt: skip
def test_what_cannot_be_read_is_named(source: bytes) -> None:
    found = alike({"ann": source, "ben": honest(OBSTACLES)["variants/compact"]}, OBSTACLES)
    assert found.groups == ()
    assert [who for who, _ in found.unread] == ["ann"]


def test_passages_are_runs_of_statements_in_any_order() -> None:
    first = b"a = 1\nb = a + 1\nwhile a < b:\n    a += 2\n    print(a)\n"
    second = b"import os\nfor e in os.listdir():\n    print(e, sep='')\n"
    left, right = statements([first + second, second + b"del x\n" + first])
    assert list(passages(left, right)) == [(0, 4, 5), (5, 0, 3)]
    assert list(passages(left, right, {shape for shape, *_ in left[:5]})) == [(5, 0, 3)]


def test_pages_show_both_side_by_side(tmp_path: Path) -> None:
    texts = honest(OBSTACLES)
    copy = edited(texts["variants/spin_once_loop"], dict(EDITS)["reorder"], "")
    texts = texts | {"ben": copy + b"\n# </code><script>alert(1)</script>\n"}
    sources = {(who, OBSTACLES): {FILE: text} for who, text in texts.items()}
    (group,) = write_likeness(tmp_path, sources, {}, "the course")[OBSTACLES].groups
    (pair,) = group.pairs
    page = (tmp_path / pair.page).read_text("utf-8")
    assert "<script" not in page
    assert page.count('id="left-') == page.count('id="right-') > 2
    assert page.count("<code") > 100
