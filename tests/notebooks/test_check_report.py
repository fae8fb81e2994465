"""The table of `check` as HTML: the terminal's words, and nothing of a student's is markup."""

from __future__ import annotations

import html
import re
from html.parser import HTMLParser
from io import StringIO
from typing import Any

import pytest
from rich.console import Console

from grader.notebook.frame import frame_html
from grader.notebook.report import COLOURS, CheckReport, grading_html
from grader.notebook.show import Progress, preformatted
from grader.report.terminal import OUTCOMES, render_terminal

HOSTILE = "<script>alert(1)</script><img src=x onerror=alert(2)>\"'&\x1b[31m\u202e"


def check(outcome: str, **changes: Any) -> dict[str, Any]:
    points = 10 if outcome == "pass" else 0
    return {
        "id": f"{outcome}_check", "title": f"A check that is {outcome}.", "kind": "core",
        "points": points, "max_points": 10, "outcome": outcome, "message": "", "expected": "",
        "actual": "", "time": None, "help": "", "scenario": None, **changes,
    }  # fmt: skip


def grading(*checks: dict[str, Any], **changes: Any) -> dict[str, Any]:
    return {
        "exercise": "obstacle_avoidance", "file": "agent.py", "tier": 1, "score": 10,
        "max_score": 30, "provisional": False, "field_ready": None, "notes": [],
        "checks": list(checks), **changes,
    }  # fmt: skip


FULL = grading(
    check("pass"),
    check("fail", message="too fast", expected="0.15 m/s", actual="0.50 m/s", time=1.5,
          scenario="avoid_wall", help="look again"),
    check("error", message="the grader failed here"),
    check("inconclusive", message="the machine stalled", scenario="avoid_wall"),
    check("unavailable", message="skipped: PyTorch is not installed here"),
    check("skip", message="not judged, because"),
    check("skip", message="not judged, because", title="Another one."),
    check("pass", kind="field", points=0, max_points=0, title="A field check."),
    provisional=True, field_ready=False, notes=["2 of 5 trials ran in real time"],
)  # fmt: skip


class Words(HTMLParser):
    """The text of a page, and its elements."""

    def __init__(self) -> None:
        super().__init__()
        self.text = ""
        self.tags: list[str] = []
        self.attributes: list[str] = []
        self._style = False

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.attributes += [name for name, _ in attrs]
        self._style = tag == "style"
        self.text += "" if tag == "b" else " "

    def handle_endtag(self, tag: str) -> None:
        self._style = False
        self.text += "" if tag == "b" else " "

    def handle_data(self, data: str) -> None:
        self.text += "" if self._style else data


def read(page: str) -> Words:
    reader = Words()
    reader.feed(page)
    return reader


@pytest.mark.parametrize("given", [FULL, grading(check("pass")), grading()])
def test_the_words_are_the_terminals(given: dict[str, Any]) -> None:
    console = Console(file=StringIO(), width=110)
    with console.capture() as said:
        render_terminal(given, console)
    terminal = re.sub("[█░]+", "", said.get()).split()

    assert sorted(read(grading_html(given)).text.split()) == sorted(terminal)


HINT = {"title": "Task 2. Hint 1", "anchor": "hints.md#task-2", "text": f"Not index 0. {HOSTILE}"}
CAUSE = {"text": f"It looks back {HOSTILE}", "kind": "core", "where": HOSTILE, "hint": HINT}


def test_the_cause_stands_above_the_table_with_its_hint_unfolded() -> None:
    given = grading(check("fail"), cause=CAUSE)
    page = grading_html(given)

    assert page.index("It looks back") < page.index("A check that is fail.")
    assert "<details open><summary>Hint: Task 2. Hint 1 (hints.md#task-2)</summary>" in page
    assert "Not index 0." in page
    assert not {"script", "img"} & set(read(page).tags)
    assert "It looks back" not in grading_html(grading(check("fail"), cause=None))


def test_every_outcome_has_a_colour_a_sign_and_a_word() -> None:
    assert COLOURS.keys() == OUTCOMES.keys()
    for colour in COLOURS.values():  # white on it: at least 4.5
        assert 1.05 / (luminance(colour) + 0.05) >= 4.5


def luminance(colour: str) -> float:
    parts = [int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)]
    linear = [x / 12.92 if x <= 0.04045 else ((x + 0.055) / 1.055) ** 2.4 for x in parts]
    return float(sum(w * x for w, x in zip((0.2126, 0.7152, 0.0722), linear, strict=True)))


def test_nothing_of_a_students_is_markup() -> None:
    texts = ("title", "message", "expected", "actual", "help", "scenario", "where", "log")
    hostile = check("fail", time=1.0, **dict.fromkeys(texts, HOSTILE))
    given = grading(hostile, exercise=HOSTILE, file=HOSTILE, notes=[HOSTILE])
    report = CheckReport(given, HOSTILE, "<p>page</p>", HOSTILE)
    page = read(report._repr_html_())

    assert "script" not in page.tags
    assert "img" not in page.tags
    assert not [name for name in page.attributes if name.startswith("on")]
    assert page.tags.count("iframe") == 1
    assert "\x1b" not in report._repr_html_()
    assert "\u202e" not in report._repr_html_()


def test_a_page_in_a_frame_is_that_page_and_reaches_nothing() -> None:
    page = f'<!DOCTYPE html><p title="a\'b">1 < 2 && {HOSTILE}</p>\n'
    frame = frame_html(page, title=HOSTILE)

    found = re.search(r'srcdoc="([^"]*)"', frame)
    assert found is not None
    assert html.unescape(found[1]) == page
    assert 'sandbox="allow-scripts"' in frame
    assert read(frame).tags == ["style", "iframe"]


def test_the_report_is_no_mark_but_says_its_points() -> None:
    report = CheckReport(FULL, "\n table\n\n", "")

    assert (report.score, report.max_score) == (10, 30)
    assert [found["id"] for found in report.checks] == [c["id"] for c in FULL["checks"]]
    assert repr(report) == " table"
    with pytest.raises(TypeError):
        float(report)  # type: ignore[arg-type]


def test_without_a_notebook_all_is_printed(capsys: pytest.CaptureFixture[str]) -> None:
    bar = Progress("Working")
    bar.update(0.5, "half")
    bar.say(HOSTILE[:25])
    CheckReport(FULL, "table", "")._ipython_display_()

    assert capsys.readouterr().out == f"{HOSTILE[:25]}\ntable\n"
    assert read(preformatted(HOSTILE)).tags == ["pre"]
