"""axe-core finds nothing to complain about in any kind of page, light or dark."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import classes
import payloads
import pytest

from grader.classroom.results import write_results
from grader.notebook.report import grading_html
from grader.report.page import page_html

pytestmark = pytest.mark.long

CAUSE = {
    "text": "The node takes the first beam for straight ahead.",
    "where": "line 12 of agent.py, in scan_callback: distance = scan.ranges[0]",
    "hint": {"title": "Task 2", "anchor": "hints.md#task-2", "text": "Not index 0."},
}


def report() -> str:
    payload = payloads.failing_page()
    payload["grading"]["cause"] = CAUSE
    return page_html(payload)


def replay() -> str:
    """As in the lesson's pages and in notebooks."""
    frame = {"grading": None, "embedded": True, "title": "one_beam_agent.py in demo_wall"}
    return page_html(payloads.failing_page() | frame)


def notebook() -> str:
    """What `check` shows, on the background of JupyterLab."""
    table = grading_html(report_grading())
    style = "body { background: light-dark(#fff, #111); color: light-dark(#000, #fff) }"
    return (
        f"<!DOCTYPE html><html lang=en><title>x</title><style>:root {{ color-scheme: light dark }} "
        f"{style}</style><main><h1>Notebook</h1>{table}</main></html>"
    )


def report_grading() -> dict[str, Any]:
    return payloads.failing_page()["grading"] | {"cause": CAUSE}


ALONE = {
    "report": report,
    "replay": replay,
    "drive": lambda: page_html(payloads.drive_page()),
    "no runs": lambda: page_html(payloads.page([], payloads.failing_checks())),
    "odd": lambda: page_html(payloads.odd_page()),
    "notebook": notebook,
}


@pytest.fixture(scope="module")
def pages(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """One page of each kind."""
    folder = tmp_path_factory.mktemp("pages")
    results, options = classes.whole_class()
    write_results(results, folder, options)
    own = folder / "feedback" / "ada"
    found = {"class": folder / "class.html", "index": own / "index.html"}
    found["feedback"] = own / "obstacle_avoidance.html"
    for name, make in ALONE.items():
        found[name] = folder / f"{name}.html"
        found[name].write_text(make(), "utf-8")
    return found


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("kind", [*ALONE, "class", "index", "feedback"])
def test_page_has_no_violations(
    browser: Any, axe: Callable[[Any], list[str]], pages: dict[str, Path], kind: str, scheme: str
) -> None:
    context = browser.new_context(color_scheme=scheme, bypass_csp=True, reduced_motion="reduce")
    page = context.new_page()
    page.goto(pages[kind].as_uri())
    found = axe(page)
    titles = page.locator("h1").count()
    context.close()
    assert found == []
    assert titles == 1


def test_a_replay_in_a_page_is_printed_without_its_controls(open_page: Callable[..., Any]) -> None:
    payload = payloads.failing_page() | {"grading": None, "embedded": True}
    page = open_page(payload)
    page.emulate_media(media="print")
    assert page.locator("canvas.map").is_visible()
    assert not page.locator(".transport").is_visible()
