"""The log of marks: nothing that goes wrong loses an entry."""

from __future__ import annotations

import errno
from pathlib import Path

import pytest
from fake_class import SLUG
from marked_class import ANN, WHY, points

from grader.classroom.amendments.change import Score
from grader.classroom.marking import marking
from grader.errors import DiskFull, GraderError


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
