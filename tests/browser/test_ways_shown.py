"""Others' ways in the page: after full marks, and asked for only then."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

import pytest
from served_site import settle, type_in

from grader.course.exercises import ROOT, find_exercise

SLUG = "obstacle_avoidance"
NEEDED = [ROOT / "build" / name for name in ("workspace/manifest.json", f"ways/{SLUG}.json")]
NAME = "Others\N{RIGHT SINGLE QUOTATION MARK} ways"
PHONE = {"viewport": {"width": 390, "height": 844}, "color_scheme": "dark", "has_touch": True}

pytestmark = pytest.mark.skipif(
    not all(file.is_file() for file in NEEDED),
    reason="the site has no ways of others here: run `make workspace` and `make ways`",
)


def test_ways_are_shown_after_full_marks_and_asked_for_only_then(
    open_served: Any, axe: Callable[[Any], list[str]]
) -> None:
    page = open_served(f"exercises/{SLUG}/README.html#workspace")
    page.locator(".cm-content:visible").wait_for()
    settle(page)
    asked: list[str] = []
    page.on("request", lambda request: asked.append(request.url))
    reference = (find_exercise(SLUG).solutions / f"{SLUG}_agent.py").read_text()
    for text, points in ((reference.replace("0.15", "0.2"), "fewer"), (reference, "100 of 100")):
        assert not any("ways" in url for url in asked)
        assert page.get_by_role("button", name=NAME).count() == 0
        type_in(page, text)
        page.keyboard.press("Control+Shift+Enter")
        assert settle(page).startswith("100 of 100") == (points != "fewer")
    page.get_by_role("button", name=NAME).press("Enter")  # by keyboard
    assert page.locator(".ws-way").count() == 2
    page.locator(".ws-way summary").first.press("Enter")
    changes = page.get_by_label(f"Changes in {SLUG}_agent.py").first
    assert "- STOP_DISTANCE = 0.5" in changes.inner_text()
    assert not {'"""', "#"} & {*changes.inner_text().split()}  # code alone, and counted alike
    count = re.search(r"Yours has (\d+) lines", page.locator(".ws-score").inner_text())
    assert count and f"the reference has {count[1]}." in page.locator(".ws-way").first.inner_text()
    assert axe(page) == []

    state = page.context.storage_state()
    phone = open_served(f"exercises/{SLUG}/README.html#workspace", storage_state=state, **PHONE)
    phone.locator(".ws-tabs button", has_text="Checks").tap()
    phone.get_by_role("button", name=NAME).tap()
    phone.locator(".ws-way summary").last.tap()
    phone.locator(".ws-way details[open]").wait_for()
    assert axe(phone) == []
    assert phone.evaluate("document.documentElement.scrollWidth <= innerWidth")
