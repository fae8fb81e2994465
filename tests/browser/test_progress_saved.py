"""Progress as one file: from a page into another, into the installed course and back."""

from __future__ import annotations

import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from served_site import settle, type_in, typed

from grader.cli import run
from grader.course.exercises import ROOT, find_exercise

MADE = ROOT / "build" / "workspace" / "manifest.json"
SLUG, FILE = "obstacle_avoidance", "obstacle_avoidance_agent.py"
OWN = 'title = "Mine"\nextends = "avoid_cart"\nseed = 7\n'
SHELF = "JSON.parse(localStorage['course-workspace:{}'])"

pytestmark = pytest.mark.skipif(
    not MADE.is_file(), reason="the site has no workspace here: run `make workspace`"
)


@pytest.fixture
def open_workspace(open_served: Any) -> Callable[..., Any]:
    def open_(slug: str = SLUG, **options: Any) -> Any:
        page = open_served(f"exercises/{slug}/README.html#workspace", **options)
        page.locator(".cm-content:visible").wait_for()
        settle(page)
        return page

    return open_


def test_work_goes_from_page_to_course_to_page(
    open_workspace: Any, axe: Callable[[Any], list[str]], tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    monkeypatch.chdir(tmp_path)
    page = open_workspace()
    reference = (find_exercise(SLUG).solutions / FILE).read_text()
    type_in(page, reference)
    page.get_by_label("seed").fill("3")
    page.keyboard.press("Control+Shift+Enter")
    assert settle(page).startswith("100 of 100")
    page.get_by_role("button", name="Progress").press("Enter")  # by keyboard
    assert axe(page) == []
    with page.expect_download() as download:
        page.keyboard.press("Enter")
    download.value.save_as("course-progress.json")
    page.keyboard.press("Escape")
    assert page.locator("dialog.workspace").is_visible()

    assert run(["progress", "course-progress.json"]) == 0
    node = tmp_path / SLUG / FILE
    assert node.read_text() == reference
    node.write_text("changed = 1\n")
    (tmp_path / SLUG / "mine.toml").write_text(OWN)
    assert run(["progress", "course-progress.json", "--export"]) == 0

    phone = {"viewport": {"width": 390, "height": 844}, "color_scheme": "dark", "has_touch": True}
    other = open_workspace(**phone)
    other.get_by_role("button", name="Progress").tap()
    other.get_by_label("Load a file").set_input_files("course-progress.json")
    other.get_by_text("its text is in the editor now").wait_for()
    assert axe(other) == []
    assert other.evaluate("document.documentElement.scrollWidth <= innerWidth")
    other.locator(".ws-progress").get_by_role("button", name="Close").tap()
    assert typed(other).strip() == "changed = 1"
    points = [each["points"] for each in other.evaluate(SHELF.format(SLUG))["versions"]]
    assert points == ["seed 3: 100 of 100"]
    other.get_by_label("Scenario", exact=True).select_option("mine.toml")
    other.get_by_role("button", name="Drive").click()
    assert settle(other).startswith("mine ended early")
    other.locator(".ws-tabs button", has_text="Code").tap()
    other.get_by_label("Earlier versions").select_option("0")
    other.get_by_role("button", name="Drive").click()
    assert settle(other) == "Driven to the end of mine."
    printed = other.get_by_label("The drive").text_content()
    assert "In a world of your own only the exercise's least is judged" in printed
    other.locator(".ws-hand summary").click()
    other.get_by_label("x [m]").fill("3")
    other.get_by_role("button", name="Put a box there").click()  # a tap's click comes later
    assert "a box at" in settle(other)
    with other.expect_download() as download:
        other.get_by_role("button", name="Save as a scenario").tap()
    assert download.value.suggested_filename == "mine_by_hand.toml"
    kept = other.evaluate(SHELF.format(SLUG))["scenarios"]
    assert list(kept) == ["mine.toml", "mine_by_hand.toml"]
    assert tomllib.loads(kept["mine_by_hand.toml"])["extends"] == "avoid_cart"
