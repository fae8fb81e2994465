"""The pages of lessons/pitfalls in a real browser, with the replays in their frames."""

import json
import re
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from frames import colours, value, wait_until

from grader.authoring.pitfalls import FOLDER, PITFALLS, REPLAYS, Pitfall, write_replays
from rclpy_virtual_time.link.hosts import ForkServer

Open = Callable[..., Any]
each_pitfall = pytest.mark.parametrize("pitfall", PITFALLS, ids=lambda pitfall: pitfall.name)


@pytest.fixture(scope="module")
def pages(site: Path, forkserver: ForkServer, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of the built pages, with their replays."""
    copy = Path(shutil.copytree(site, tmp_path_factory.mktemp("site") / "html"))
    write_replays(copy / FOLDER.name / REPLAYS, forkserver)
    return copy / FOLDER.name


@pytest.fixture
def open_pitfall(open_file: Open, pages: Path) -> Open:
    return lambda name, **options: open_file(pages / f"{name}.html", **options)


def open_frame(page: Any, name: str) -> Any:
    """Scroll to a replay, wait until it has made its frame fit, and return what is in it."""
    source = f'.replay iframe[src="{REPLAYS}/{name}.html"]'
    frame = page.locator(source)
    frame.scroll_into_view_if_needed()
    wait_until(page, f"document.querySelector('{source}').style.height")
    return frame.element_handle().content_frame()


def payload_of(pages: Path, name: str) -> dict[str, Any]:
    text = (pages / REPLAYS / f"{name}.html").read_text("utf-8")
    found = re.search(r'id="payload">(.*?)</script>', text, re.DOTALL)
    assert found
    replay: dict[str, Any] = json.loads(found[1])["replays"][0]
    return replay


@each_pitfall
def test_replays_open_where_it_goes_wrong_and_play(
    open_pitfall: Open, pages: Path, pitfall: Pitfall
) -> None:
    page = open_pitfall(pitfall.name)
    page.locator(".challenge .quiet").click()  # the right node's replay comes after a guess
    titles = page.locator("iframe").evaluate_all("(all) => all.map((frame) => frame.title)")
    assert len(titles) == len(set(titles)) == len(pitfall.nodes)
    for node in pitfall.nodes:
        assert any(f"{node}.py" in title for title in titles)
        name = pitfall.replay_of(node)
        frame = open_frame(page, name)
        moments = payload_of(pages, name)["moments"]
        start = moments[0]["t"] if moments else 0.0
        assert bool(moments) == (node in pitfall.wrong)
        assert value(frame, "time") == pytest.approx(start)
        assert frame.locator(".annotation").is_visible() == bool(moments)
        assert colours(frame, "canvas.map") > 5
        assert colours(frame, "canvas.plot") > 5
        frame.locator("canvas.map").focus()
        page.keyboard.press("Space")
        assert value(frame, "playing")
        value(frame, "advance(0.3)")
        page.keyboard.press("Space")
        assert not value(frame, "playing")
        assert value(frame, "time") >= start + 0.3


@pytest.mark.parametrize("width", [390, 1280])
def test_frames_fit_and_nothing_is_wider_than_the_screen(open_pitfall: Open, width: int) -> None:
    page = open_pitfall("no_stop_without_model", viewport={"width": width, "height": 844})
    frame = open_frame(page, "no_stop_without_model_wrong")
    height, inner = frame.evaluate("[document.documentElement.scrollHeight, innerHeight]")
    assert abs(height - inner) <= 1
    assert frame.evaluate("document.documentElement.scrollWidth <= innerWidth")
    assert page.evaluate("document.documentElement.scrollWidth") <= width


def test_replays_follow_the_reader_s_choice_of_light_or_dark(open_pitfall: Open) -> None:
    page = open_pitfall("twist_stamped", color_scheme="dark")
    frame = open_frame(page, "twist_stamped_wrong")
    dark = "getComputedStyle(document.body).backgroundColor.match(/\\d+/g).map(Number)[0] < 60"
    wait_until(frame, dark)
    for theme, seen in (("light", f"!({dark})"), ("auto", dark)):
        page.evaluate(f"document.body.dataset.theme = '{theme}'")
        wait_until(frame, seen)
