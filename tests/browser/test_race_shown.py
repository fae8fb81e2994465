"""A race in a real browser: figures, ghosts, one's own best, the file for the class."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

import msgspec
import pytest
from served_site import settle, type_in

from grader.course.exercises import ROOT, find_exercise
from grader.drive.race import reference_laps
from grader.drive.standings import read_result

pytestmark = pytest.mark.skipif(
    not (ROOT / "build" / "workspace" / "manifest.json").is_file(),
    reason="the site has no workspace here: run `make workspace`",
)
SEEK = "(t) => { window.replayPlayer.pause(); window.replayPlayer.seek(t); }"


def raced(page: Any, text: str) -> str:
    """Race with a node's text; return what is said of it."""
    for tab in ("Code", "Checks"):  # in a narrow window
        if page.get_by_role("button", name=tab, exact=True).is_visible():
            page.get_by_role("button", name=tab, exact=True).click()
        if tab == "Code":
            type_in(page, text)
    page.get_by_role("button", name="Race", exact=True).press("Enter")
    return settle(page)


def opened(open_served: Any, slug: str, **options: Any) -> tuple[Any, str]:
    """Open an exercise; return the page, and the reference's text."""
    page = open_served(f"exercises/{slug}/README.html#workspace", **options)
    page.locator(".cm-content:visible").wait_for()
    settle(page)
    exercise = find_exercise(slug)
    return page, (exercise.solutions / exercise.files[0]).read_text("utf-8")


def cells(page: Any, who: str) -> list[list[str]]:
    rows = page.locator(".ws-race tr", has=page.get_by_role("rowheader", name=who, exact=True))
    return [row.split("\t")[1:] for row in rows.all_inner_texts()]


def test_a_result_is_saved_by_nickname_and_read_by_the_command(
    open_served: Any, axe: Callable[[Any], list[str]]
) -> None:
    page, text = opened(open_served, "goal_seeking")
    assert raced(page, text) == "Race: 3 of 3 worlds finished."
    assert cells(page, "yours") == cells(page, "reference") != []
    assert cells(page, "your best") == []
    assert axe(page) == []
    assert "Ranked by the worlds finished" in page.locator(".ws-score").inner_text()
    page.get_by_label("Nickname").press("Enter")  # nothing is saved without one
    page.get_by_label("Nickname").fill("Ada L.")
    with page.expect_download() as download:
        page.get_by_label("Nickname").press("Enter")
    assert page.locator(".ws-status").inner_text().endswith("by the nickname “Ada L.”.")
    assert download.value.suggested_filename == "race_goal_seeking_Ada_L.json"
    result = read_result(download.value.path())
    assert (result.exercise, result.nickname) == ("goal_seeking", "Ada L.")
    shipped = reference_laps("goal_seeking")
    for lap in result.laps:  # a sine there may differ in its last digit, and so a digest
        assert lap == msgspec.structs.replace(shipped[lap.world][0], recording=lap.recording)


@pytest.mark.parametrize(("scheme", "width"), [("light", 1280), ("dark", 390)])
def test_ones_own_best_drives_along_and_is_kept(
    open_served: Any, axe: Callable[[Any], list[str]], scheme: str, width: int
) -> None:
    look = {"color_scheme": scheme, "viewport": {"width": width, "height": 844}}
    page, text = opened(open_served, "obstacle_avoidance", **look)
    raced(page, text)
    faster = text.replace("return SLOW_SPEED", "return FULL_SPEED / 2")
    assert raced(page, faster) == "Race: 3 of 3 worlds finished."
    assert cells(page, "your best") == cells(page, "reference") != cells(page, "yours")
    assert axe(page) == []
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    frame = page.locator(".ws-replay iframe").element_handle().content_frame()
    said = []
    for moment in (2.0, 6.0):
        frame.evaluate(SEEK, moment)
        said.append(frame.locator(".player > [role=status]").text_content().split("; ")[1:])
    assert [ghost.partition(" at ")[0] for ghost in said[0]] == ["reference", "your best"]
    assert said[0] != said[1]  # they are somewhere else then
    assert frame.locator(".ghost").all_text_contents() == ["reference", "your best"]
    assert "Outlines show other runs" in frame.locator(".event-start").first.text_content()
    slower = faster.replace("FULL_SPEED = 0.5", "FULL_SPEED = 0.4")
    raced(page, slower)
    lost = r"From .* s it loses .* m to your best\."
    assert re.search(lost, page.locator(".ws-race").inner_text())
    assert "race: 3 of 3, " in page.get_by_label("Earlier versions").inner_text()
    page.reload()
    page.locator(".cm-content:visible").wait_for()
    settle(page)
    faster_yet = faster.replace("distance < STOP_DISTANCE", "distance < 0.0")
    assert raced(page, faster_yet) == "Race: 2 of 3 worlds finished."  # not past the cart
    assert "touched something at" in page.locator(".ws-race").inner_text()
    kept = page.evaluate("JSON.parse(localStorage['course-workspace:obstacle_avoidance']).race")
    best = float(cells(page, "your best")[1][0])
    assert kept["demo_race_cart"]["lap"]["figure"] == best
