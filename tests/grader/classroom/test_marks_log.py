"""The log of marks: nothing that goes wrong loses an entry."""

from __future__ import annotations

import errno
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from fake_class import FILE, SLUG
from marked_class import ANN, WHY, judged, points

from grader.classroom.amendments import (
    Score,
)
from grader.classroom.marking import Marking, marking, reading
from grader.errors import DiskFull, GraderError, InputError


def test_what_could_not_be_read_again_does_not_get_in(graded: Path) -> None:
    """JSON has no NaN: an entry that nobody can read would block all others."""
    with marking(graded) as class_, pytest.raises(InputError, match="expected a change"):
        class_.add(Score(SLUG, float("nan"), ANN), "prof", WHY)
    with reading(graded) as class_:
        assert class_.entries == []


@pytest.mark.parametrize("ends", [KeyboardInterrupt(), OSError(errno.ENOSPC, "full")])
def test_what_ends_while_results_are_written_is_in_the_log(
    graded: Path, monkeypatch: pytest.MonkeyPatch, ends: BaseException
) -> None:
    def end(*_: object) -> None:
        raise ends

    with monkeypatch.context() as patch:
        patch.setattr("grader.classroom.folder.write_results", end)
        with pytest.raises((KeyboardInterrupt, DiskFull)) as caught, marking(graded) as class_:
            class_.add(Score(SLUG, 85, ANN), "prof", WHY)
    if isinstance(caught.value, DiskFull):
        assert "course marks write" in str(caught.value)
    assert points(graded)["ann"] == "70"
    with marking(graded) as class_:
        class_.write()
    assert points(graded)["ann"] == "85"


def test_two_at_once(graded: Path) -> None:
    with marking(graded), pytest.raises(GraderError, match="another"), marking(graded):
        pass


@pytest.fixture
def odd_names(handed_in: Path) -> Iterator[list[str]]:
    names = ["=1+1", "--all", "<img src=x onerror=alert(1)>", "-h", "@SUM(A1)"]
    for name in names:
        (handed_in / name).mkdir()
        (handed_in / name / FILE).write_text(f"# {name}\n")
    yield names


def test_names_that_are_formulas_options_or_html(
    odd_names: list[str], grade_class: Any, tmp_path: Path
) -> None:
    grade_class(judged)
    out = tmp_path / "out"
    with marking(out) as class_:
        whom = class_.whom(["=1+1", "--all", "-h"], "", everybody=False)
        class_.add(Score(SLUG, 85, whom), "=cmd()", "<script>alert(1)</script>")
        odd: Marking = class_
        assert len(odd.students) == 8
    found = points(out)
    assert [found[name] for name in ("'=1+1", "'--all", "'-h", "'@SUM(A1)")] == [
        "85", "85", "85", "70",
    ]  # fmt: skip
    page = (out / "class.html").read_text("utf-8")
    assert "<script>" not in page
    assert "&lt;script&gt;alert(1)" in page
    assert "<img" not in page
