"""The report and its replay player in a real browser. Time is driven by hooks, never slept."""

import json
from collections.abc import Callable
from typing import Any

import payloads
import pytest
from frames import pixels, value, wait_until

Open = Callable[..., Any]


def at_start(page: Any) -> Any:
    """Go back from the failure at which a page opens."""
    value(page, "selectRun(0)")
    return page


def press(page: Any, *keys: str) -> None:
    for key in keys:
        page.keyboard.press(key)


# --- the graph -----------------------------------------------------------------------------


@pytest.mark.parametrize("width", [390, 1280])
def test_each_run_has_its_graph_and_no_name_is_too_long(open_page: Open, width: int) -> None:
    graphs = [payloads.graph("/laser", f"/{'very_long_name/' * 9}scan"), "", payloads.graph()]
    pages = payloads.page([payloads.wall_run(), payloads.goal_run(), payloads.goal_run()])
    page = open_page(pages | {"graphs": graphs}, viewport={"width": width, "height": 800})
    drawn = page.locator(".player-head .graph-part[open] svg")  # above the map: the robot stands
    assert drawn.bounding_box()["width"] > 300
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    for run in (1, 2):
        value(page, f"selectRun({run})")
        assert drawn.count() == 0


# --- the page ------------------------------------------------------------------------------


def test_shows_the_score_the_badge_and_every_check(open_page: Open) -> None:
    page = open_page(payloads.failing_page())
    assert page.locator(".score-figure").inner_text().split("\n")[0].startswith("60")
    assert "Not field-ready yet" in page.locator(".badge").inner_text()
    checks = payloads.failing_checks()
    assert page.locator(".check").count() == len(checks)
    words = page.locator(".check-word").all_inner_texts()
    assert set(words) == {
        "Passed", "Failed", "Skipped", "Grader error", "Inconclusive", "Not installed"
    }  # fmt: skip


def test_notes_stand_under_the_score_as_text(open_page: Open) -> None:
    payload = payloads.failing_page()
    payload["grading"]["notes"] = ["18 of 18 trials ran in real time.", payloads.HOSTILE]
    page = open_page(payload)
    notes = page.locator(".score-note").all_inner_texts()
    assert notes[0] == "18 of 18 trials ran in real time."
    assert len(notes) == 2


def test_failed_checks_are_open_and_say_all_that_is_known(open_page: Open) -> None:
    page = open_page(payloads.failing_page())
    failed = page.locator(".check.is-fail").first
    text = failed.inner_text()
    stop = payloads.wall_run()["moments"][0]
    for part in ("title", "message", "expected", "actual", "help"):
        assert stop[part] in text
    assert "Show 8.66" in text.replace("\u00a0", " ")


def test_a_drive_has_no_score(open_page: Open) -> None:
    page = open_page(payloads.drive_page())
    assert page.locator(".score").count() == 0
    assert page.locator(".check").count() == 0
    assert page.locator("canvas.map").is_visible()


def test_a_page_without_runs_says_so(open_page: Open) -> None:
    page = open_page(payloads.page([], payloads.failing_checks()))
    assert "There is no run to replay." in page.locator(".replay-column").inner_text()
    assert page.evaluate("window.replayPlayer") is None


@pytest.mark.parametrize("width", [360, 1600])
@pytest.mark.parametrize("name", ["failing_page", "odd_page"])
def test_nothing_is_wider_than_the_screen(open_page: Open, name: str, width: int) -> None:
    page = open_page(getattr(payloads, name)(), viewport={"width": width, "height": 800})
    assert page.evaluate("document.documentElement.scrollWidth") <= width


# --- playing -------------------------------------------------------------------------------


def test_playing_moves_the_robot(open_page: Open) -> None:
    page = at_start(open_page(payloads.drive_page()))
    before, start = pixels(page), value(page, "state.pose.x")
    page.get_by_role("button", name="Play").click()
    wait_until(page, "window.replayPlayer.time > 0.3")
    page.get_by_role("button", name="Pause").click()
    assert not value(page, "playing")
    assert value(page, "state.pose.x") > start + 0.1
    assert pixels(page) != before


def test_the_keyboard_drives_the_player(open_page: Open) -> None:
    page = at_start(open_page(payloads.drive_page()))
    press(page, "ArrowRight", "ArrowRight")
    assert value(page, "time") == pytest.approx(0.2)  # two scans of a 10 Hz lidar
    press(page, "ArrowLeft")
    assert value(page, "time") == pytest.approx(0.1)
    press(page, "Shift+ArrowRight")
    assert value(page, "time") == pytest.approx(1.1)
    press(page, "End")
    assert value(page, "time") == value(page, "duration")
    press(page, "Home", "]", "]")
    assert (value(page, "time"), value(page, "rate")) == (0, 4)
    press(page, "[", "[", "[", "[", "[", "[")
    assert value(page, "rate") == 0.25
    press(page, "Space")
    assert value(page, "playing")
    press(page, "Space")
    assert not value(page, "playing")
    press(page, "?")
    assert page.locator("dialog.help").is_visible()
    press(page, "Escape")
    assert not page.locator("dialog.help").is_visible()


def test_n_and_p_walk_through_the_moments(open_page: Open) -> None:
    page = at_start(open_page(payloads.drive_page()))
    first, second = (moment["t"] for moment in payloads.wall_run()["moments"])
    press(page, "n")
    assert value(page, "time") == pytest.approx(first)
    press(page, "n")
    assert value(page, "time") == pytest.approx(second)
    press(page, "n")  # there is no third
    assert value(page, "time") == pytest.approx(second)
    press(page, "p")
    assert value(page, "time") == pytest.approx(first)


def test_the_slider_follows_the_mouse_and_the_keyboard(open_page: Open) -> None:
    page = at_start(open_page(payloads.failing_page()))
    slider = page.get_by_role("slider")
    box = slider.bounding_box()
    page.mouse.click(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    assert value(page, "time") == pytest.approx(6.0, abs=0.05)
    press(page, "Home")
    slider.focus()
    press(page, "ArrowRight")
    assert slider.get_attribute("aria-valuetext") == "0.50 s of 12.00 s"  # the first command


def test_screen_readers_hear_of_steps_but_not_of_playing(open_page: Open) -> None:
    page = at_start(open_page(payloads.drive_page()))
    press(page, "ArrowRight")
    told = page.get_by_role("status").inner_text()
    assert told.replace("\u00a0", " ").startswith("0.10 s: robot at (0.05, 0.00)")
    press(page, "Space")
    wait_until(page, "window.replayPlayer.time > 0.3")
    assert page.evaluate("document.querySelector('[role=status]').textContent") == told
    press(page, "Space")


# --- failing moments -------------------------------------------------------------------------


def test_a_failed_check_leads_to_its_moment(open_page: Open) -> None:
    page = at_start(open_page(payloads.failing_page()))
    page.get_by_role("button", name="Show 8.66").click()
    assert value(page, "run") == 1
    assert value(page, "time") == pytest.approx(8.66)
    assert not value(page, "playing")
    annotation = page.locator(".annotation").inner_text()
    stop = payloads.wall_run()["moments"][0]
    assert stop["expected"] in annotation
    assert stop["actual"] in annotation


def test_with_motion_a_jump_plays_the_second_before(open_page: Open) -> None:
    page = open_page(payloads.failing_page(), reduced_motion="no-preference")
    value(page, "setRate(8)")
    page.get_by_role("button", name="Show 8.66").click()
    assert 7.6 < value(page, "time") <= 8.66
    assert page.locator(".annotation").is_visible()
    wait_until(page, "!window.replayPlayer.playing")
    assert value(page, "time") == pytest.approx(8.66)


def test_the_account_tells_the_run(open_page: Open) -> None:
    said = "Compute: 0.4 ms a message (p50)"
    page = open_page(payloads.page([{**payloads.wall_run(), "compute": [said]}]))
    account = page.locator(".account-list").inner_text().replace("\u00a0", " ")
    for part in (
        "The robot starts at (0.00, 0.00), heading 0°.",
        "First command: 0.50 m/s",
        "Contact: the robot touches something",
        "The scenario ran to its end.",
        "Check failed: Closer than 0.5 m the robot stands still.",
        said,
    ):
        assert part in account


def test_the_log_follows_the_time(open_page: Open) -> None:
    page = open_page(payloads.drive_page())
    value(page, "seek(10.04)")
    assert page.locator(".log-line.is-now").inner_text().split()[0] == "10.00"
    visible = page.evaluate(
        """(() => { const list = document.querySelector('.log-list').getBoundingClientRect();
        const row = document.querySelector('.is-now').getBoundingClientRect();
        return row.top >= list.top && row.bottom <= list.bottom; })()"""
    )
    assert visible


# --- the map ---------------------------------------------------------------------------------


def test_zoom_pan_fit_and_follow(open_page: Open) -> None:
    page = at_start(open_page(payloads.drive_page()))
    start = value(page, "view")
    box = page.locator("canvas.map").bounding_box()
    middle = (box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    page.mouse.move(*middle)
    page.mouse.wheel(0, -200)  # not clicked yet: the page's own scrolling
    assert value(page, "view.scale") == start["scale"]
    page.mouse.click(*middle)
    page.mouse.wheel(0, -200)
    wait_until(page, f"window.replayPlayer.view.scale > {start['scale']} * 1.1")
    page.mouse.down()
    page.mouse.move(middle[0] + 80, middle[1], steps=3)
    page.mouse.up()
    assert value(page, "view.x") < start["x"] - 0.2
    press(page, "0")
    assert value(page, "view") == pytest.approx(start)
    press(page, "f")
    value(page, "seek(4)")
    assert value(page, "following")
    assert value(page, "view.x") == pytest.approx(value(page, "state.pose.x"))


def test_the_plot_shows_turning_on_demand(open_page: Open) -> None:
    page = open_page(payloads.drive_page())
    before = pixels(page, "canvas.plot")
    page.get_by_role("button", name="Angular").click()
    assert pixels(page, "canvas.plot") != before
    assert page.get_by_role("button", name="Angular").get_attribute("aria-pressed") == "true"


def test_the_toggle_switches_between_light_and_dark(open_page: Open) -> None:
    page = open_page(payloads.failing_page(), color_scheme="dark")
    dark = "getComputedStyle(document.body).backgroundColor.match(/\\d+/g).map(Number)[0] < 60"
    before = pixels(page)
    assert page.evaluate(dark)
    page.get_by_role("button", name="Switch between light and dark").click()
    assert not page.evaluate(dark)
    assert pixels(page) != before


# --- hostile and odd data ----------------------------------------------------------------------


def test_hostile_text_stays_text(open_page: Open) -> None:
    page = open_page(payloads.odd_page())
    assert page.evaluate("window.pwned") is None
    assert page.locator("img").count() == 0
    assert page.locator("script").count() == 2
    assert "<img src=x onerror" in page.locator("h1").inner_text()


def test_the_policy_forbids_what_is_not_ours(open_page: Open) -> None:
    page = open_page(payloads.drive_page(), may_complain=True)
    page.evaluate(
        """() => { window.refused = 0;
        document.addEventListener('securitypolicyviolation', () => { window.refused += 1; });
        const script = document.createElement('script');
        script.textContent = 'window.pwned = 1';
        document.body.append(script); }"""
    )
    wait_until(page, "window.refused > 0")
    assert page.evaluate("window.pwned") is None


def test_odd_data_can_be_played_through(open_page: Open) -> None:
    page = open_page(payloads.odd_page())
    for _ in range(len(payloads.odd_page()["replays"])):
        for key in ("End", "ArrowLeft", "Home", "ArrowRight", "n", "p", "f", "+", "-", "0"):
            press(page, key)
        value(page, "play()")
        value(page, "advance(0.7)")
        value(page, "pause()")
        value(page, "selectRun(1)")
    assert value(page, "run") == 1
    assert value(page, "time") == 0


@pytest.mark.parametrize("replay", [{}, None, {"truth": None, "world": [], "scans": {"beams": -1}}])
def test_a_replay_with_nothing_in_it(open_page: Open, replay: Any) -> None:
    page = open_page({"grading": None, "replays": [replay], "title": ""})
    press(page, "Space", "End", "ArrowRight", "n")
    assert value(page, "duration") == 0


def test_a_player_can_be_mounted_elsewhere(open_page: Open) -> None:
    page = open_page(payloads.drive_page())
    second = json.dumps(payloads.page([payloads.goal_run()]))
    page.evaluate(
        f"""() => {{ const root = document.createElement('div'); document.body.append(root);
        window.second = window.mountPlayer(root, {second}); }}"""
    )
    assert page.locator(".player").count() == 2
    assert page.evaluate("window.second.duration") == 12
    page.evaluate("window.second.destroy()")
    assert page.locator(".player").count() == 1
