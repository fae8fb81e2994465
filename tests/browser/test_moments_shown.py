"""What ran at a moment of the replay, in a real browser: after a drive and after a check."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from served_site import settle, stand_at, type_in

from grader.course.exercises import ROOT, find_exercise

pytestmark = pytest.mark.skipif(
    not (ROOT / "build" / "workspace" / "manifest.json").is_file(),
    reason="the site has no workspace here: run `make workspace`",
)


def begun(open_served: Any, slug: str, **options: Any) -> Any:
    """Open an exercise's workspace, with its reference in the editor."""
    page = open_served(f"exercises/{slug}/README.html#workspace", **options)
    page.locator(".cm-content:visible").wait_for()
    settle(page)
    exercise = find_exercise(slug)
    type_in(page, (exercise.solutions / exercise.files[0]).read_text("utf-8"))
    return page


def told(page: Any) -> dict[str, list[str]]:
    """Return the table's rows, by what stands at their beginning."""
    settle(page)
    rows = page.locator(".ws-tables tbody tr:has(td)").all()
    return {row.locator("th").inner_text(): row.locator("td").all_inner_texts() for row in rows}


def test_two_moments_of_a_drive_stand_side_by_side(
    open_served: Any, axe: Callable[[Any], list[str]]
) -> None:
    page = begun(open_served, "goal_seeking")
    page.get_by_label("Scenario", exact=True).select_option("demo_open")
    page.keyboard.press("Control+Enter")
    assert "Driven to the end" in settle(page)
    stand_at(page, 2.01, ".ws-look")
    page.locator(".ws-look summary").focus()
    page.keyboard.press("Enter")  # by keyboard alone
    page.locator(".ws-tables table").wait_for()
    assert told(page)["Function"] == [
        "odom_callback of /goal_seeking_agent, goal_seeking_agent.py, line 95"
    ]
    assert "* heard" in told(page)
    assert page.locator(".cm-lintRange-info").count() == 1  # the line, in the editor
    assert axe(page) == []
    stand_at(page, 4.01, ".ws-look")
    page.get_by_role("button", name="Compare 4.01 s with 2.01 s").click()
    page.locator(".ws-tables th[scope=col]").nth(1).wait_for()
    stand_at(page, 1.01, ".ws-look")
    page.get_by_role("button", name="Compare 1.01 s with 2.01 s").click()
    page.locator(".ws-tables th[scope=col]", has_text="1.01").wait_for()
    assert "2.01" in page.locator(".ws-tables th[scope=col]").nth(1).inner_text()
    page.locator(".ws-tables th[scope=col]").nth(1).wait_for()
    assert len(told(page)["* pose"]) == 2
    assert told(page)["Called by"] == ["a message on /odom"] * 2
    assert axe(page) == []
    page.get_by_label("Function").select_option("control_callback")
    page.locator(".ws-tables td", has_text="control_callback of").first.wait_for()
    assert told(page)["Called by"] == ["its timer of 0.1 s"] * 2
    page.get_by_label("Function").select_option("odom_callback")
    page.locator(".ws-tables td", has_text="odom_callback of").first.wait_for()
    type_in(page, "pass")  # what is looked into is the run that was made
    page.get_by_label("Time to look at").fill("3.01")
    page.get_by_label("Time to look at").press("Enter")
    page.locator(".ws-tables th", has_text="by 3.01 s").wait_for()
    assert "odom_callback" in told(page)["Function"][0]
    assert page.locator(".cm-lintRange-info").count() == 0
    assert page.locator(".ws-look .ws-since").is_visible()  # and it is said


def test_a_look_leaves_what_failed_marked_and_a_new_run_is_told_of(open_served: Any) -> None:
    page = begun(open_served, "live_parameters")
    for _ in range(2):
        text = (find_exercise("live_parameters").solutions / "live_parameters_agent.py").read_text()
        type_in(page, text.replace("twist = Twist()", "twist = Twist(1 / 0)"))
        page.keyboard.press("Control+Enter")
        assert "ended early" in settle(page)
        assert page.locator(".ws-printed").is_visible()  # no panel hides it
        assert page.locator(".ws-look .ws-since").is_hidden()
        page.locator(".ws-look summary", has_text="by 0.01 s").click()  # once it is there
        page.locator(".ws-tables table").wait_for()
        settle(page)
        assert page.locator(".ws-printed").is_hidden()
        assert page.locator(".cm-lintRange-info").count() == 1
        assert page.locator(".cm-lintRange-error").count() == 1


def test_a_moment_of_a_check_on_a_phone(open_served: Any, axe: Callable[[Any], list[str]]) -> None:
    phone = {"viewport": {"width": 390, "height": 844}, "color_scheme": "dark", "has_touch": True}
    page = begun(open_served, "obstacle_avoidance", **phone)
    page.keyboard.press("Control+Shift+Enter")
    assert settle(page).startswith("100 of 100")
    page.get_by_role("button", name="Replay", exact=True).tap()
    replay = page.frame_locator(".ws-replay iframe")
    replay.get_by_role("combobox").first.select_option(index=1)
    page.locator(".ws-look summary").tap()
    page.locator(".ws-tables").get_by_text("Nothing of the node had run").or_(
        page.locator(".ws-tables table")).first.wait_for()  # fmt: skip
    settle(page)
    page.get_by_label("Moment to look at").fill("1.5")
    page.get_by_role("button", name="Look at 1.50 s").tap()
    page.locator(".ws-tables th", has_text="by 1.50 s").wait_for()
    assert told(page)["Called by"] == ["a message on /scan"]
    assert axe(page) == []
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
