"""How long the rest of a class will take: what is put off does not count against it."""

import io
import re

import pytest
from rich.console import Console

from grader.classroom import progress


def test_what_is_put_off_does_not_make_the_estimate_grow(monkeypatch: pytest.MonkeyPatch) -> None:
    seconds = iter(range(0, 6000, 60))
    monkeypatch.setattr(progress.time, "monotonic", lambda: next(seconds))
    monkeypatch.setattr(progress, "EVERY", 1)
    said = io.StringIO()
    shown = progress.Progress(Console(file=said, width=200))
    shown.begin(20)

    for number in range(20):  # a minute each
        shown.done(f"student {number}", "exercise", "will retry", over=number % 2 == 0)

    left = [int(text) for text in re.findall(r"about (\d+) min", said.getvalue())]
    assert (left[0], left[-1]) == (19, 10)
    assert left == sorted(left, reverse=True)
