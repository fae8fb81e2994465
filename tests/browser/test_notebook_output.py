"""What `drive` and `check` show below a cell, in a real Chromium: the frame's page draws itself."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import payloads
import pytest

from grader.notebook.frame import frame_html
from grader.notebook.report import CheckReport
from grader.report.page import page_html

NOTEBOOK = """\
<!DOCTYPE html><html><head><meta charset="utf-8"><title>Notebook</title>
<script>window.reached = [];</script></head>
<body data-jp-theme-light="{light}" style="font-family:sans-serif;background:{back};color:{ink}">
<div class="jp-OutputArea-output">{output}</div></body></html>
"""
THEMES = {"light": ("#ffffff", "#1f1f1f"), "dark": ("#111111", "#e0e0e0")}


def page_of(replays: list[dict[str, Any]]) -> str:
    return page_html(
        {"grading": None, "replays": replays, "title": payloads.HOSTILE, "embedded": True}
    )


@pytest.fixture
def open_output(browser: Any, tmp_path: Path) -> Iterator[Any]:
    """Open HTML as a cell's output; nothing may be complained about or asked for."""
    contexts, complaints, requests = [], [], []

    def open_(output: str, theme: str = "light", system: str = "light", width: int = 1000) -> Any:
        context = browser.new_context(
            viewport={"width": width, "height": 900}, color_scheme=system, reduced_motion="reduce"
        )
        contexts.append(context)
        page = context.new_page()
        page.on("console", lambda message: complaints.append(message.text))
        page.on("pageerror", lambda error: complaints.append(str(error)))
        page.on("dialog", lambda dialog: complaints.append(dialog.message))
        page.on("request", lambda request: requests.append(request.url))
        back, ink = THEMES[theme]
        file = tmp_path / "notebook.html"
        light = str(theme == "light").lower()
        file.write_text(
            NOTEBOOK.format(output=output, back=back, ink=ink, light=light), encoding="utf-8"
        )
        page.goto(file.as_uri())
        return page

    yield open_
    for context in contexts:
        context.close()
    assert complaints == []
    assert [url for url in requests if not url.startswith(("file:", "data:", "about:"))] == []


def frame_in(page: Any) -> Any:
    element = page.wait_for_selector("iframe")
    element.scroll_into_view_if_needed()
    frame = element.content_frame()
    frame.wait_for_selector("canvas.map")
    return frame


def still(frame: Any) -> float:
    """Wait until the replay stands; return where."""
    frame.evaluate(
        """() => new Promise((resolve, reject) => {
          const end = performance.now() + 20000;
          const look = () => {
            if (!window.replayPlayer.playing) resolve();
            else if (performance.now() > end) reject(new Error('waited too long'));
            else requestAnimationFrame(look);
          };
          look();
        })"""
    )
    return float(frame.evaluate("window.replayPlayer.time"))


def report(outcome: str = "fail") -> CheckReport:
    checks = [check for check in payloads.failing_checks() if check["outcome"] in (outcome, "pass")]
    grading = {
        "exercise": payloads.HOSTILE, "file": payloads.HOSTILE, "tier": 1, "score": 5,
        "max_score": 10, "field_ready": None, "checks": checks,
    }  # fmt: skip
    return CheckReport(grading, "table", page_of([payloads.wall_run()]), payloads.HOSTILE)


@pytest.mark.parametrize("theme", THEMES)
def test_the_replay_draws_itself_in_a_sandboxed_frame(open_output: Any, theme: str) -> None:
    page = open_output(frame_html(page_of([payloads.wall_run()]), title="Replay"), theme)
    frame = frame_in(page)

    colours = frame.evaluate(
        """() => {
          const map = document.querySelector('canvas.map');
          const {data} = map.getContext('2d').getImageData(0, 0, map.width, map.height);
          const seen = new Set();
          for (let i = 0; i < data.length; i += 4) seen.add(data.slice(i, i + 3).join());
          return seen.size;
        }"""
    )
    assert colours > 10
    assert frame.locator("h1:not(.hidden-text)").count() == 0  # the notebook says that


PARTS = (".stage", ".readout", ".transport", ".plot", ".log-list", ".account-part summary")


@pytest.mark.parametrize("width", [600, 860, 1200])
def test_nothing_of_the_replay_is_cut_off(open_output: Any, width: int) -> None:
    """No script of a notebook makes the frame taller: all of the player is in view."""
    output = frame_html(page_of([payloads.wall_run()]), title="Replay")
    frame = frame_in(open_output(output, width=width))
    still(frame)

    height, inner = frame.evaluate("[document.documentElement.scrollHeight, innerHeight]")
    assert height <= inner + 1
    assert frame.evaluate("document.documentElement.scrollWidth <= innerWidth")
    for part in PARTS:
        bottom = frame.evaluate(
            "(part) => document.querySelector(part).getBoundingClientRect().bottom", part
        )
        assert bottom <= inner, part
    assert frame.evaluate("document.querySelector('.map').clientHeight") >= 180
    assert frame.evaluate("document.querySelector('.account-part').open") == (width == 1200)


def test_a_frame_that_is_too_low_scrolls(open_output: Any) -> None:
    output = frame_html(page_of([payloads.wall_run()]), title="Replay", height=400)
    frame = frame_in(open_output(output))

    assert frame.evaluate("document.documentElement.scrollHeight > innerHeight")
    assert frame.evaluate("document.querySelector('.map').clientHeight") >= 180


@pytest.mark.parametrize("theme", THEMES)
def test_the_replay_is_as_dark_as_the_notebook(open_output: Any, theme: str) -> None:
    output = frame_html(page_of([payloads.wall_run()]), title="Replay")
    page = open_output(output, theme, "null")  # Chromium's own: an override would win in the frame

    dark = "matchMedia('(prefers-color-scheme: dark)').matches"
    assert frame_in(page).evaluate(dark) is (theme == "dark")


def test_it_stands_at_the_first_failing_moment(open_output: Any) -> None:
    frame = frame_in(open_output(frame_html(page_of([payloads.wall_run()]), title="Replay")))

    moment = payloads.wall_run()["moments"][0]
    assert still(frame) == pytest.approx(moment["t"])
    assert moment["title"] in frame.locator(".annotation").inner_text()


def test_it_plays(open_output: Any) -> None:
    frame = frame_in(open_output(frame_html(page_of([payloads.wall_run()]), title="Replay")))

    still(frame)
    frame.evaluate("window.replayPlayer.seek(0)")
    frame.locator(".play-button").click()
    assert frame.evaluate("window.replayPlayer.playing") is True
    frame.evaluate("window.replayPlayer.advance(1)")
    assert frame.evaluate("window.replayPlayer.time") >= 1


def test_the_frame_cannot_reach_the_notebook(open_output: Any) -> None:
    page = open_output(frame_html(page_of([payloads.wall_run()]), title="Replay"))
    frame = frame_in(page)

    refused = frame.evaluate(
        "() => { try { window.parent.reached.push(1); return 'reached'; }"
        " catch (error) { return error.name; } }"
    )
    assert refused == "SecurityError"
    assert page.evaluate("window.reached") == []


@pytest.mark.parametrize("theme", THEMES)
def test_the_table_can_be_read_and_a_students_text_is_text(open_output: Any, theme: str) -> None:
    page = open_output(report()._repr_html_(), theme)

    table = page.locator(".course-check")
    assert payloads.HOSTILE.split()[0] in table.inner_text()
    assert table.locator("script, img").count() == 0
    chips = page.locator(".course-check .chip").all_inner_texts()
    assert {re.sub(r"\W", "", chip) for chip in chips} == {"FAIL", "pass"}
    box = table.bounding_box()
    assert box["x"] + box["width"] <= 1000
    assert page.evaluate("document.documentElement.scrollWidth") <= 1000


def test_facts_stand_in_two_columns(open_output: Any) -> None:
    page = open_output(report()._repr_html_())

    names = page.locator(".facts span:nth-child(odd)").all()
    assert names
    for name in names:
        assert name.bounding_box()["height"] < 30  # one line


def test_replays_are_unfolded_only_if_something_failed(open_output: Any) -> None:
    failed = open_output(report("fail")._repr_html_())
    assert failed.locator("details[open] iframe").count() == 1
    passed = open_output(report("pass")._repr_html_())
    assert passed.locator("details:not([open]) iframe").count() == 1
    passed.locator("summary").click()
    box = frame_in(passed).locator("canvas.map").bounding_box()
    assert box["width"] > 500  # it fits itself to the frame that was folded away
