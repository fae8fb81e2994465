"""The lesson's programs in a real browser: driven where they are shown, changed, driven again."""

import re
from collections.abc import Callable
from typing import Any

import pytest
from served_site import SLOW, settle, type_in, typed

from grader.authoring.pitfalls import NODES
from grader.course.exercises import ROOT
from workspace.runtime import REFUSED

MADE = ROOT / "build" / "workspace" / "manifest.json"
PRINTED = "[aria-label='What course drive prints']"
FOR_EVER = "while True:\n    pass\n"
BEAT = "beat.py --scenario demo_wall --duration 6 --param threads:=2 --param separate:=true"

pytestmark = pytest.mark.skipif(
    not MADE.is_file(), reason="the site has no workspace here: run `make workspace`"
)


def shown_below(page: str, command: str) -> list[str]:
    """Return the lines of the output below a command, without those that stand for others."""
    text = re.sub(r" \\\n +", " ", (ROOT / "lessons" / f"{page}.md").read_text("utf-8"))
    at = re.escape(f"```console\n$ course drive {command}\n```\n\n```output")
    found = re.search(at + r"(?: log)?\n(.*?)^```$", text, re.DOTALL | re.MULTILINE)
    assert found, f"lessons/{page}.md: expected {command} with its output"
    return [line for line in found[1].splitlines() if line and line != "…"]


def press(page: Any, name: str, exact: bool = True) -> None:
    """Press a button of the page; what it lies folded in is unfolded."""
    page.locator("body[data-workspace=ready]").wait_for()
    page.evaluate("document.querySelectorAll('details').forEach((each) => { each.open = true; })")
    page.get_by_role("button", name=name, exact=exact).click()


def driven(page: Any) -> str:
    """Wait for the end of a drive; return what the page prints."""
    page.locator("dialog[open] .cm-content").wait_for()
    printed = page.locator(f"dialog[open][aria-busy=false] {PRINTED}:not([hidden])")
    printed.wait_for(timeout=SLOW, state="attached")
    return str(printed.text_content())


def test_the_front_page_lets_a_robot_drive_and_leads_to_the_first_exercise(
    open_served: Any,
) -> None:
    page = open_served("index.html")
    page.locator("body[data-workspace=ready]").wait_for()
    page.locator(".start a").first.click()
    printed = driven(page)
    for line in shown_below("index", "wander.py --scenario demo_store --seed 1 --duration 40"):
        assert line in printed
    assert settle(page) == "Driven to the end of demo_store."
    page.frame_locator(".ws-replay iframe").locator(".clock").wait_for()
    page.get_by_role("button", name="Close").click()
    page.locator(".start a").nth(1).click()
    page.locator("dialog.workspace .cm-content").wait_for()
    assert "obstacle_avoidance" in page.url


def test_a_program_is_changed_and_driven_again_and_the_change_is_kept(open_served: Any) -> None:
    page = open_served("loop.html")
    press(page, "Drive it here: one_beam_agent.py --scenario demo_wall")
    first = driven(page)
    expected = shown_below("loop", "one_beam_agent.py --scenario demo_wall")
    assert [line for line in first.splitlines() if line in expected] == expected
    assert page.locator(".ws-printed").nth(1).inner_text().split() == " ".join(expected).split()
    assert page.locator("mark").count() == 0
    listing = page.locator(".drive-here").first.get_attribute("data-code")
    assert listing.count("1.5") == 1
    type_in(page, listing.replace("1.5", "1.0"))
    page.keyboard.press("Control+Enter")
    page.locator("dialog mark").first.wait_for(timeout=SLOW)
    marked = page.locator("dialog mark").all_inner_texts()
    assert [line.split()[0] for line in marked] == ["drove", "nearest"]
    assert "With your changes" in page.locator(".ws-note").first.inner_text()
    page.reload()
    page.locator("dialog[open] .cm-content").wait_for()
    assert "distance > 1.0" in typed(page)
    page.get_by_role("button", name="Reset").click()
    assert "distance > 1.5" in typed(page)
    page.keyboard.press("Escape")  # closes it
    press(page, "Drive it here: one_beam_agent.py --scenario demo_wall --param decision:=table")
    assert "drove 2.24 m" in driven(page)


def test_arguments_are_typed_and_those_without_sense_are_refused(open_served: Any) -> None:
    page = open_served("loop.html")
    press(page, "Drive it here: one_beam_agent.py --scenario demo_wall")
    driven(page)
    line = page.get_by_label("Arguments of course drive")
    for words, said in (
        ("--scenario demo_wal", "did you mean 'demo_wall'?"),
        ("--scenario demo_wall --report it.html", REFUSED["--report"]),
        ("--scenario demo_wall --duration 2", "2.0 s simulated"),
    ):
        line.fill(words)
        line.press("Enter")
        page.locator(PRINTED, has_text=said).wait_for(timeout=SLOW)
        settle(page)
    page.reload()  # the address has the arguments of the last drive
    page.locator("dialog[open] .cm-content").wait_for()
    assert line.input_value() == "--scenario demo_wall --duration 2"
    page.locator(".cm-content").focus()
    page.keyboard.press("Escape")
    assert page.evaluate("document.activeElement.matches('.cm-content')")


def test_a_link_carries_code_and_arguments_and_drives_nothing(open_served: Any) -> None:
    page = open_served("plans.html", permissions=["clipboard-read", "clipboard-write"])
    press(page, "Drive it here: errand.py --scenario demo_open --duration 25")
    driven(page)
    type_in(page, "# mine")
    page.get_by_label("Arguments of course drive").fill("--scenario demo_wall")
    page.get_by_role("button", name="Link").click()
    page.locator(".ws-status", has_text="Copied").wait_for()
    link = page.evaluate("navigator.clipboard.readText()")
    page.goto("about:blank")
    page.goto(link)
    page.locator("dialog[open] .cm-line", has_text="# mine").wait_for()
    assert page.get_by_label("Arguments of course drive").input_value() == "--scenario demo_wall"
    assert "Ready." in settle(page)
    assert page.locator(PRINTED).is_hidden()


def test_another_program_stops_the_one_that_never_ends(open_served: Any) -> None:
    page = open_served("real_time.html")
    press(page, "Drive it here: stale.py --scenario demo_wall --duration 10")
    driven(page)
    type_in(page, FOR_EVER)
    page.keyboard.press("Control+Enter")
    page.locator(".ws-status", has_text="Driving stale.py").wait_for()
    page.get_by_role("button", name="Close").click()
    press(page, f"Drive it here: {BEAT}")
    printed = driven(page)  # of two threads
    for text in shown_below("real_time", BEAT):
        assert text in printed


def test_without_threads_the_page_says_so(open_served: Any) -> None:
    page = open_served("real_time.html", "delete WebAssembly.Suspending")
    press(page, f"Drive it here: {BEAT}")
    page.locator("dialog[open] .ws-status", has_text="This program needs threads").wait_for()
    assert page.get_by_role("button", name="Drive", exact=True).is_disabled()


def test_a_pitfall_is_mended_in_place_once_somebody_has_guessed(open_served: Any) -> None:
    page = open_served("pitfalls/front_by_index.html")
    page.locator("body[data-workspace=ready]").wait_for()
    button = page.get_by_role("button", name="Mend it here")
    assert not button.is_visible()
    page.locator("#line").fill("14")
    page.locator("#line").press("Enter")
    button.click()
    assert "TOUCHED" in driven(page)
    type_in(page, (NODES / "wall_stop_right.py").read_text("utf-8"))
    page.keyboard.press("Control+Enter")
    page.locator("dialog mark").first.wait_for(timeout=SLOW)
    assert "TOUCHED" not in driven(page)


@pytest.mark.parametrize(("scheme", "width"), [("light", 1280), ("dark", 1280), ("light", 390)])
def test_axe_has_nothing_against_a_drive(
    open_served: Any, axe: Callable[[Any], list[str]], scheme: str, width: int
) -> None:
    page = open_served("loop.html", color_scheme=scheme, viewport={"width": width, "height": 844})
    button = "Drive it here: one_beam_agent.py --scenario demo_wall"
    press(page, button)
    driven(page)
    page.get_by_label("Arguments of course drive").fill("--scenario demo_wall --seed 7")
    page.get_by_label("Arguments of course drive").press("Enter")
    page.locator("dialog mark").first.wait_for(timeout=SLOW, state="attached")
    settle(page)
    assert axe(page) == []
    if width < 800:
        page.get_by_role("button", name="Output").click()
        assert axe(page) == []
    page.get_by_role("button", name="Close").click()
    assert axe(page) == []
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    page.emulate_media(media="print")
    assert not page.get_by_role("button", name=button, exact=True).is_visible()
