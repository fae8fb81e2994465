"""axe-core has nothing against any kind of page with a report or a replay, light or dark."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import payloads
import pytest

from grader.notebook.report import grading_html
from grader.report.page import page_html

CAUSE = {
    "text": "The node takes the first beam for straight ahead.",
    "where": "line 12 of agent.py, in scan_callback: distance = scan.ranges[0]",
    "hint": {"title": "Task 2", "anchor": "hints.md#task-2", "text": "Not index 0."},
}
GRADING = payloads.failing_page()["grading"] | {"cause": CAUSE}
EMBEDDED = {"grading": None, "embedded": True, "title": "one_beam_agent.py in demo_wall"}
NOTEBOOK = """\
<!DOCTYPE html><html lang=en><title>x</title><style>:root {{ color-scheme: light dark }}
body {{ background: light-dark(#fff, #111); color: light-dark(#000, #fff) }}</style>
<main><h1>Notebook</h1>{table}</main></html>
"""
PAGES: dict[str, Callable[[], str]] = {
    "report": lambda: page_html(payloads.failing_page() | {"grading": GRADING}),
    "replay": lambda: page_html(payloads.failing_page() | EMBEDDED),  # of the lesson, in notebooks
    "drive": lambda: page_html(payloads.drive_page()),
    "graph": lambda: page_html(payloads.drive_page() | {"graphs": [payloads.graph("/a", "/b")]}),
    "no runs": lambda: page_html(payloads.page([], payloads.failing_checks())),
    "odd": lambda: page_html(payloads.odd_page()),
    "notebook": lambda: NOTEBOOK.format(table=grading_html(GRADING)),
}


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("kind", PAGES)
def test_page_has_no_violations(
    open_file: Any, axe: Callable[[Any], list[str]], tmp_path: Path, kind: str, scheme: str
) -> None:
    file = tmp_path / "page.html"
    file.write_text(PAGES[kind](), "utf-8")
    page = open_file(file, color_scheme=scheme, bypass_csp=True)
    assert axe(page) == []
    assert page.locator("h1").count() == 1
