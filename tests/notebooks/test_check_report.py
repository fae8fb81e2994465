"""The table of `check` as HTML: the terminal's words, and nothing of a student's is markup."""

import html
import re
from io import StringIO
from typing import Any

import payloads
import pytest
from html_pages import Page
from rich.console import Console

from grader.notebook.frame import frame_html
from grader.notebook.report import CheckReport, grading_html
from grader.notebook.show import Progress, preformatted
from grader.report.terminal import render_terminal

HOSTILE = "<script>alert(1)</script><img src=x onerror=alert(2)>\"'&\x1b[31m\u202e"


def check(outcome: str, **changes: Any) -> dict[str, Any]:
    title = f"A check that is {outcome}."
    return payloads.check(f"{outcome}_check", title, outcome) | changes


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


def words(page: str) -> list[str]:
    return sorted(" ".join(Page(re.sub(r"(?s)<style>.*?</style>|</?b>", "", page)).texts).split())


@pytest.mark.parametrize("given", [FULL, grading(check("pass")), grading()])
def test_the_words_are_the_terminals(given: dict[str, Any]) -> None:
    console = Console(file=StringIO(), width=110)
    with console.capture() as said:
        render_terminal(given, console, everything=True)
    terminal = re.sub("[█░]+", "", said.get()).split()
    assert words(grading_html(given)) == sorted(terminal)


HINT = {"title": "Task 2. Hint 1", "anchor": "hints.md#task-2", "text": f"Not index 0. {HOSTILE}"}
CAUSE = {"text": f"It looks back {HOSTILE}", "kind": "core", "where": HOSTILE, "hint": HINT}


def test_the_cause_stands_above_the_table_with_its_hint_unfolded() -> None:
    given = grading(check("fail"), cause=CAUSE)
    page = grading_html(given)
    assert page.index("It looks back") < page.index("A check that is fail.")
    assert "<details open><summary>Hint: Task 2. Hint 1 (hints.md#task-2)</summary>" in page
    assert "Not index 0." in page
    assert "It looks back" not in grading_html(grading(check("fail"), cause=None))


def test_nothing_of_a_students_is_markup() -> None:
    texts = ("title", "message", "expected", "actual", "help", "scenario", "where", "log")
    hostile = check("fail", time=1.0, **dict.fromkeys(texts, HOSTILE))
    given = grading(hostile, exercise=HOSTILE, file=HOSTILE, notes=[HOSTILE])
    report = CheckReport(given, HOSTILE, "<p>page</p>", HOSTILE)
    page = Page(report._repr_html_())
    assert not {"script", "img"} & set(page.tags)
    assert not [name for _, name, _ in page.attributes if name.startswith("on")]
    assert page.tags.count("iframe") == 1
    assert not {"\x1b", "\u202e"} & set(report._repr_html_())


def test_a_page_in_a_frame_is_that_page_and_reaches_nothing() -> None:
    page = f'<!DOCTYPE html><p title="a\'b">1 < 2 && {HOSTILE}</p>\n'
    frame = frame_html(page, title=HOSTILE)
    found = re.search(r'srcdoc="([^"]*)"', frame)
    assert found is not None
    assert html.unescape(found[1]) == page
    assert 'sandbox="allow-scripts"' in frame
    assert Page(frame).tags == ["style", "iframe"]


def test_without_a_notebook_all_is_printed(capsys: pytest.CaptureFixture[str]) -> None:
    bar = Progress("Working")
    bar.update(0.5, "half")
    bar.say(HOSTILE[:25])
    CheckReport(FULL, "table", "")._ipython_display_()
    assert capsys.readouterr().out == f"{HOSTILE[:25]}\ntable\n"
    assert Page(preformatted(HOSTILE)).tags == ["pre"]
