"""Every control of a report can be reached by keyboard and hit with a finger; it opens where it
matters, and prints whole."""

from collections.abc import Callable
from typing import Any

import payloads
import pytest
from frames import value

Open = Callable[..., Any]

PHONE = {"viewport": {"width": 390, "height": 844}, "has_touch": True, "is_mobile": True}
FINGER = 44  # [CSS pixels] WCAG 2.2, 2.5.5
CONTROLS = 'button, select, summary, [role=slider], [tabindex="0"]'
SMALL = f"""() => [...document.querySelectorAll('{CONTROLS}')]
  .filter((e) => e.checkVisibility() && !e.disabled && !e.closest('.log-line'))
  .map((e) => [e.getBoundingClientRect(), e])
  .filter(([box]) => box.width < {FINGER} || box.height < {FINGER})
  .map(([box, e]) => `${{box.width}} x ${{box.height}} ${{e.outerHTML.slice(0, 90)}}`)"""
FOCUSED = "document.activeElement.className + ' ' + (document.activeElement.ariaLabel || '')"


def passing_page() -> dict[str, Any]:
    """A full score: a bench, on which the robot gets far for nothing, and a drive."""
    bench = payloads.replay(
        scenario="bench",
        title="The bench",
        bench=True,
        outcome={"kind": "exception", "text": "ValueError", "at": 4.0},  # as it should
        duration=90.0,
        truth={key: [0.0] * 4 for key in ("y", "yaw", "v", "w", "clearance", "contact")}
        | {"t": [0.0, 30.0, 60.0, 90.0], "x": [0.0, 15.0, 30.0, 45.0]},
    )
    return payloads.page([bench, payloads.goal_run()], [payloads.check("wiring", "It starts.")])


# --- where it opens -------------------------------------------------------------------------------


def test_a_report_opens_at_the_first_failure(open_page: Open) -> None:
    page = open_page(payloads.failing_page())  # its first run is all right
    assert (value(page, "run"), value(page, "time")) == (1, pytest.approx(8.66))
    assert not value(page, "playing")
    assert page.locator(".annotation").is_visible()


def test_a_failure_without_a_moment_opens_its_run_where_it_ended(open_page: Open) -> None:
    died = payloads.goal_run() | {"outcome": {"kind": "exception", "text": "KeyError", "at": 4.0}}
    failed = payloads.check("wiring", "It starts.", "fail", scenario=died["scenario"])
    page = open_page(payloads.page([payloads.replay(), died], [failed]))
    assert (value(page, "run"), value(page, "time")) == (1, pytest.approx(4.0))


def test_a_full_score_opens_at_a_drive_and_not_at_a_bench(open_page: Open) -> None:
    page = open_page(passing_page())
    assert value(page, "run") == 1
    assert value(page, "state.v") > 0.1
    judged = passing_page()["grading"]["checks"]
    page = open_page(passing_page() | {"grading": None, "embedded": True, "judged": judged})
    assert value(page, "run") == 1  # in a frame, too


def test_a_drive_opens_at_its_start_or_where_it_went_wrong(open_page: Open) -> None:
    page = open_page(payloads.page([payloads.goal_run()]))
    assert value(page, "time") == 0
    touches = {**payloads.wall_run(), "moments": []}
    page = open_page(payloads.page([touches]))
    assert value(page, "state.touching")


def test_a_page_opens_where_its_maker_says(open_page: Open) -> None:
    """A search knows when the node failed; a time that is out of range is brought back into it."""
    for wanted, shown in ((7.5, 7.5), (99.0, 12.0)):
        page = open_page({**payloads.page([payloads.goal_run(12.0)]), "opens_at": wanted})
        assert value(page, "time") == shown


# --- the keyboard ---------------------------------------------------------------------------------


def test_after_show_the_keyboard_is_in_the_player_and_escape_leads_back(open_page: Open) -> None:
    page = open_page(payloads.failing_page())
    show = page.get_by_role("button", name="Show 8.66")
    show.focus()
    page.keyboard.press("Enter")
    assert "play-button" in page.evaluate(FOCUSED)
    page.keyboard.press("ArrowRight")
    assert value(page, "time") > 8.66
    page.keyboard.press("Escape")
    focused = page.evaluate("document.activeElement.textContent").replace("\u00a0", " ")
    assert "Show 8.66" in focused


def test_the_tab_key_reaches_every_control(open_page: Open) -> None:
    page = open_page(payloads.failing_page())
    page.evaluate(
        f"""() => {{ window.reached = new Set();
        document.addEventListener('focusin', (event) => window.reached.add(event.target));
        window.missed = () => [...document.querySelectorAll('{CONTROLS}')]
          .filter((e) => e.checkVisibility() && !e.disabled && !e.closest('dialog')
            && !e.closest('.log-line') && !window.reached.has(e)).map((e) => e.outerHTML); }}"""
    )
    for _ in range(page.locator(CONTROLS).count()):
        page.keyboard.press("Tab")
    assert page.evaluate("window.missed()") == []
    assert page.evaluate("[...window.reached].some((e) => e.closest('.log-line'))")


def test_the_arrows_walk_through_the_log(open_page: Open) -> None:
    page = open_page(payloads.drive_page())
    value(page, "seek(0)")
    lines = page.locator(".log-line button")
    assert lines.evaluate_all("(all) => all.filter((e) => e.tabIndex === 0).length") == 1
    lines.first.focus()
    for key in ("ArrowDown", "ArrowDown", "ArrowUp", "Enter"):
        page.keyboard.press(key)
    assert value(page, "time") == pytest.approx(0.1)


# --- a finger -------------------------------------------------------------------------------------


def test_a_finger_hits_every_control(open_page: Open) -> None:
    page = open_page(payloads.failing_page(), **PHONE)
    assert page.evaluate(SMALL) == []


def test_failures_that_are_close_share_a_mark_and_take_turns(open_page: Open) -> None:
    run = payloads.wall_run()
    run["moments"] = [payloads.moment(t, "x", f"At {t}.") for t in (4.0, 4.2, 9.0)]
    page = open_page(payloads.page([run]), **PHONE)
    marks = page.locator(".mark-moment")
    assert marks.count() == 2
    assert marks.first.inner_text() == "2"
    for t in (4.2, 4.0):  # it opened at 4.0
        marks.first.click()
        assert value(page, "time") == pytest.approx(t)


# --- paper ----------------------------------------------------------------------------------------


def test_on_paper_nothing_is_folded_away_and_no_map_is_black(open_page: Open) -> None:
    payload = payloads.failing_page()
    hint = {"title": "T", "anchor": "a", "text": "H"}
    payload["grading"]["cause"] = {"text": "It.", "hint": hint}
    page = open_page(payload, color_scheme="dark")
    folded = "document.querySelectorAll('.cause details:not([open])').length"
    theme = "document.documentElement.dataset.theme || ''"
    assert page.evaluate(folded) == 1
    page.evaluate("window.dispatchEvent(new Event('beforeprint'))")
    assert (page.evaluate(folded), page.evaluate(theme)) == (0, "light")
    page.evaluate("window.dispatchEvent(new Event('afterprint'))")
    assert (page.evaluate(folded), page.evaluate(theme)) == (1, "")


def test_a_printed_drive_has_its_whole_log(open_page: Open) -> None:
    page = open_page(payloads.drive_page())
    page.emulate_media(media="print")
    log = page.locator(".log-list")
    assert log.evaluate("(e) => e.scrollHeight <= e.clientHeight + 1")
