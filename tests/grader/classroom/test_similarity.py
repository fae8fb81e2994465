"""Similar submissions: what the class report calls alike, and what it doesn't."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from made_results import OBSTACLES, classes

from grader.classroom.results.similarity import (
    LONGEST,
    MOST,
    similar_groups,
    tokens,
    words_of,
)

# --- similar submissions ------------------------------------------------------------------------


def renamed(source: bytes) -> bytes:
    """Other names, comments and line breaks, the same program."""
    text = re.sub(r"\bpart_(\d)", r"stage_\1", source.decode()).replace("scan", "reading")
    return text.replace("# ", "# mine: ").replace("\n        ", "\n\n        ").encode()


def test_renaming_hides_nothing_and_the_skeleton_is_no_similarity() -> None:
    original, other = classes.program(3), classes.program(4)
    texts = {
        "ada": {"a.py": original},
        "ben": {"a.py": renamed(original)},
        "chen": {"a.py": other},
        "dan": {"a.py": original + b"\n" + other[: len(other) // 9]},
    }
    groups = similar_groups(words_of(texts), {})
    assert [group.students for group in groups] == [("ada", "ben", "dan")]
    assert groups[0].similarity == 1.0
    del texts["dan"]  # what he added is a part of chen's
    assert similar_groups(words_of(texts), {"a.py": original}) == []


def test_the_courses_own_solutions_are_not_similar() -> None:
    folder = Path(__file__).resolve().parents[3] / "solutions" / OBSTACLES
    files = [folder / "obstacle_avoidance_agent.py", *sorted(folder.glob("variants/*.py"))]
    texts = {file.stem: {"a.py": file.read_bytes()} for file in files}
    assert len(texts) > 5
    assert similar_groups(words_of(texts), {}) == []


def test_what_half_the_class_has_is_common_ground() -> None:
    shared = classes.program(3)
    texts = {f"s{i}": {"a.py": shared + classes.program(100 + i)[17:]} for i in range(12)}
    assert similar_groups(words_of(texts), {}) == []
    assert len(similar_groups(words_of(dict(list(texts.items())[:2])), {})) <= 1


def test_a_line_without_end_takes_no_time() -> None:
    whole = b"x = " + b'\\"' * 450_000 + b"\n"  # each of the quotes might begin a string
    before = tokens(b"y = f(1)\n" * 50)
    words = tokens(b"y = f(1)\n" * 50 + whole)
    assert words[: len(before)] == before
    assert len(words) < len(before) + 2 * LONGEST


@pytest.mark.parametrize(
    "source",
    [
        b"", b"\x00\xff", b"def (", b"\tif x:\n  y", b"# coding: rot13\nx", b"# coding: idna\nx",
        b"# coding: utf-16\nx = 1\n", b"# coding: unicode_escape\nx = '\\", b"(" * 2**20,
        b"\\\n" * 2**19, b"a " * 2**19, b"0_" * 2**19, b"'''\n" * 2**18,
    ],
)  # fmt: skip
def test_no_file_stops_the_search_or_takes_long(source: bytes) -> None:
    assert len(tokens(source)) <= MOST
