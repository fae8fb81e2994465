"""A hand on the knob in a real browser: set, answered, undone, saved; a box, the e-stop."""

from __future__ import annotations

import tomllib
from collections.abc import Callable
from typing import Any

import pytest
from served_site import settle, stand_at, type_in

from grader.course.exercises import ROOT, find_exercise

pytestmark = pytest.mark.skipif(
    not (ROOT / "build" / "workspace" / "manifest.json").is_file(),
    reason="the site has no workspace here: run `make workspace`",
)


def driven(open_served: Any, slug: str, scenario: str, **options: Any) -> Any:
    """Drive an exercise's reference, and open what can be done by hand."""
    page = open_served(f"exercises/{slug}/README.html#workspace", **options)
    page.locator(".cm-content:visible").wait_for()
    settle(page)
    exercise = find_exercise(slug)
    type_in(page, (exercise.solutions / exercise.files[0]).read_text("utf-8"))
    page.get_by_label("Scenario", exact=True).select_option(scenario)
    page.keyboard.press("Control+Enter")
    assert "Driven to the end" in settle(page)
    page.locator(".ws-hand summary").click()
    return page


def test_a_knob_is_turned_answered_undone_and_saved(
    open_served: Any, axe: Callable[[Any], list[str]]
) -> None:
    page = driven(open_served, "live_parameters", "demo_wall")
    replay = page.frame_locator(".ws-replay iframe")
    row = page.locator(".ws-knob", has_text="cruise_speed")
    assert "speed where the way is free [m/s], 0.0 to 0.5; now 0.3" in row.inner_text()
    stand_at(page, 2.0, ".ws-hand")
    row.get_by_role("slider").fill("0.1")
    row.get_by_role("button", name="Set cruise_speed").click()
    assert settle(page).startswith("2.00 s: cruise_speed:=0.1: accepted. Driven to the end")
    replay.locator(".clock", has_text="2.00 /").wait_for()  # and stays there
    frame = page.locator(".ws-replay iframe").element_handle().content_frame()
    assert frame.evaluate("window.replayPlayer.time") == 2.0
    assert "now 0.1" in row.inner_text()
    slow = page.get_by_label("slow_distance", exact=True)
    for moment, value, said in (
        (3.0, "0.4", "refused: slow_distance (0.4 m) must not be below"),
        (2.5, "2", "refused: Wrong parameter type"),  # as `ros2 param set` would send it
    ):
        stand_at(page, moment, ".ws-hand")
        slow.fill(value)
        slow.press("Enter")  # by keyboard alone
        assert f"{moment:.2f} s: slow_distance:={value}: {said}" in settle(page)
    assert replay.locator(".mark-deed").count() == replay.locator(".event-deed").count() == 3
    assert axe(page) == []
    page.get_by_role("button", name="Undo slow_distance:=2 at 2.50 s").click()
    settle(page)
    with page.expect_download() as download:
        page.get_by_role("button", name="Save as a scenario").click()
    assert settle(page).startswith("Saved: demo_wall_by_hand.toml, also below Your own")
    command = "course drive live_parameters_agent.py --scenario demo_wall_by_hand.toml"
    assert command in page.locator(".ws-hand").inner_text()
    orders = tomllib.loads(download.value.path().read_text("utf-8"))["program"][1]["arguments"]
    assert orders[1:] == ["2.0 cruise_speed:=0.1", "3.0 slow_distance:=0.4"]
    stand_at(page, 15.0, ".ws-hand")
    page.get_by_role("button", name="Set cruise_speed").click()
    assert settle(page).startswith("The run is over")


def test_a_box_is_put_where_the_map_was_clicked_and_another_drive_begins_anew(
    open_served: Any, axe: Callable[[Any], list[str]]
) -> None:
    phone = {"viewport": {"width": 390, "height": 800}, "color_scheme": "dark"}
    page = driven(open_served, "safety_supervisor", "demo_full_speed", **phone)
    page.get_by_label("Moment of the replay").fill("2")
    page.get_by_role("button", name="Press the e-stop").click()
    assert "2.00 s: e-stop pressed" in settle(page)
    page.get_by_role("button", name="Release the e-stop").wait_for()
    page.frame_locator(".ws-replay iframe").locator("canvas.map").click(position={"x": 30, "y": 40})
    fields = [page.get_by_label(f"{axis} [m]") for axis in "xy"]
    page.wait_for_function("(x) => x.value !== '0'", arg=fields[0].element_handle())
    x, y = (float(field.input_value()) for field in fields)
    page.get_by_role("button", name="Put a box there").click()
    assert f"a box at ({x:.2f}, {y:.2f})" in settle(page)
    assert page.locator(".ws-done li").count() == 2
    assert axe(page) == []
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    page.get_by_label("Scenario", exact=True).select_option("demo_wall")
    page.keyboard.press("Control+Enter")
    assert settle(page).startswith("Driven to the end of demo_wall.")
    assert page.locator(".ws-done li").count() == 0
