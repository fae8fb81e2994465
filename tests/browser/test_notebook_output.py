"""What `drive` and `check` show below a cell, in a real Chromium: the frame's page draws itself."""

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import payloads
import pytest
from frames import colours, wait_until

from grader.notebook.frame import frame_html
from grader.notebook.report import CheckReport
from grader.report.page import page_html

NOTEBOOK = """\
<!DOCTYPE html><html><head><meta charset="utf-8"><title>Notebook</title>
<script>window.reached = [];</script></head>
<body data-jp-theme-light="{light}"><div class="jp-OutputArea-output">{output}</div></body></html>
"""
EMBEDDED = {"grading": None, "title": payloads.HOSTILE, "embedded": True}
PAGE = page_html({**EMBEDDED, "replays": [payloads.wall_run()]})
PARTS = (".stage", ".readout", ".transport", ".plot", ".log-list", ".account-part summary")
Open = Callable[..., Any]


@pytest.fixture
def open_output(open_file: Open, tmp_path: Path) -> Open:
    """Open HTML as a cell's output."""

    def open_(output: str, theme: str = "light", width: int = 1000) -> Any:
        file = tmp_path / "notebook.html"
        file.write_text(
            NOTEBOOK.format(output=output, light=str(theme == "light").lower()), encoding="utf-8"
        )
        # Chromium's own colours: an override would win in the frame
        size = {"width": width, "height": 900}
        return open_file(file, color_scheme="null", viewport=size)

    return open_


def frame_in(page: Any) -> Any:
    """Return the replay's frame when it stands still."""
    element = page.wait_for_selector("iframe")
    element.scroll_into_view_if_needed()
    frame = element.content_frame()
    frame.wait_for_selector("canvas.map")
    wait_until(frame, "!window.replayPlayer.playing")
    return frame


def report(outcome: str = "fail") -> CheckReport:
    checks = [check for check in payloads.failing_checks() if check["outcome"] in (outcome, "pass")]
    grading = {
        "exercise": payloads.HOSTILE, "file": payloads.HOSTILE, "tier": 1, "score": 5,
        "max_score": 10, "field_ready": None, "checks": checks,
    }  # fmt: skip
    return CheckReport(grading, "table", PAGE, payloads.HOSTILE)


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_the_replay_draws_itself_as_dark_as_the_notebook(open_output: Open, theme: str) -> None:
    frame = frame_in(open_output(frame_html(PAGE, title="Replay"), theme))

    assert colours(frame) > 10
    assert frame.locator("h1:not(.hidden-text)").count() == 0  # the notebook says that
    dark = "matchMedia('(prefers-color-scheme: dark)').matches"
    assert frame.evaluate(dark) is (theme == "dark")


@pytest.mark.parametrize("width", [600, 1200])
def test_nothing_of_the_replay_is_cut_off(open_output: Open, width: int) -> None:
    """No script of a notebook makes the frame taller: all of the player is in view."""
    frame = frame_in(open_output(frame_html(PAGE, title="Replay"), width=width))

    height, inner = frame.evaluate("[document.documentElement.scrollHeight, innerHeight]")
    assert height <= inner + 1
    assert frame.evaluate("document.documentElement.scrollWidth <= innerWidth")
    for part in PARTS:
        bottom = frame.evaluate(
            "(part) => document.querySelector(part).getBoundingClientRect().bottom", part
        )
        assert bottom <= inner, part


def test_the_frame_cannot_reach_the_notebook(open_output: Open) -> None:
    page = open_output(frame_html(PAGE, title="Replay"))

    refused = frame_in(page).evaluate(
        "() => { try { window.parent.reached.push(1); return 'reached'; }"
        " catch (error) { return error.name; } }"
    )
    assert refused == "SecurityError"
    assert page.evaluate("window.reached") == []


def test_the_table_can_be_read_and_a_students_text_is_text(open_output: Open) -> None:
    page = open_output(report()._repr_html_())

    table = page.locator(".course-check")
    assert payloads.HOSTILE.split()[0] in table.inner_text()
    assert table.locator("script, img").count() == 0
    chips = page.locator(".course-check .chip").all_inner_texts()
    assert {re.sub(r"\W", "", chip) for chip in chips} == {"FAIL", "pass"}
    assert page.evaluate("document.documentElement.scrollWidth") <= 1000


def test_replays_are_unfolded_only_if_something_failed(open_output: Open) -> None:
    failed = open_output(report("fail")._repr_html_())
    assert failed.locator("details[open] iframe").count() == 1
    passed = open_output(report("pass")._repr_html_())
    assert passed.locator("details:not([open]) iframe").count() == 1
    passed.locator("summary").click()
    box = frame_in(passed).locator("canvas.map").bounding_box()
    assert box["width"] > 500  # it fits itself to the frame that was folded away
