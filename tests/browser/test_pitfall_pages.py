"""The pages of lessons/pitfalls in a real browser, with the replays in their frames."""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from grader.authoring.pitfalls import FOLDER, PITFALLS, REPLAYS, Pitfall, write_replays
from grader.link.hosts import ForkServer

pytestmark = pytest.mark.long
DESK, TELEPHONE = {"width": 1280, "height": 900}, {"width": 390, "height": 844}
Open = Callable[..., Any]
each_pitfall = pytest.mark.parametrize("pitfall", PITFALLS, ids=lambda pitfall: pitfall.name)


@pytest.fixture(scope="module")
def pages(site: Path, forkserver: ForkServer, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of the built pages, with their replays."""
    copy = Path(shutil.copytree(site, tmp_path_factory.mktemp("site") / "html"))
    write_replays(copy / FOLDER.name / REPLAYS, forkserver)
    return copy / FOLDER.name


@pytest.fixture
def open_pitfall(browser: Any, pages: Path) -> Iterator[Open]:
    """Open a page; at the end nothing may have been complained about, missing or on the network."""
    contexts, complaints, requests = [], [], []

    def open_(name: str, **options: Any) -> Any:
        context = browser.new_context(**{"viewport": DESK, "reduced_motion": "reduce"} | options)
        contexts.append(context)
        page = context.new_page()
        page.on("console", lambda message: complaints.append(message.text))
        page.on("pageerror", lambda error: complaints.append(str(error)))
        page.on("requestfailed", lambda request: complaints.append(request.url))
        page.on("request", lambda request: requests.append(request.url))
        page.goto((pages / f"{name}.html").as_uri())
        return page

    yield open_
    for context in contexts:
        context.close()
    assert complaints == []
    assert [url for url in requests if not url.startswith(("file:", "data:"))] == []


def open_frame(page: Any, node: str) -> Any:
    """Scroll to a replay, wait until it has made its frame fit, and return what is in it."""
    source = f'.replay iframe[src="{REPLAYS}/{node}.html"]'
    frame = page.locator(source)
    frame.scroll_into_view_if_needed()
    wait_until(page, f"document.querySelector('{source}').style.height")
    return frame.element_handle().content_frame()


def wait_until(place: Any, condition: str) -> None:
    """Look at each frame; Playwright's own waiting needs eval, which the replays forbid."""
    place.evaluate(
        f"""() => new Promise((resolve, reject) => {{
          const end = performance.now() + 20000;
          const look = () => {{
            if ({condition}) resolve();
            else if (performance.now() > end) reject(new Error('waited too long'));
            else requestAnimationFrame(look);
          }};
          look();
        }})"""
    )


def payload_of(pages: Path, node: str) -> dict[str, Any]:
    text = (pages / REPLAYS / f"{node}.html").read_text("utf-8")
    found = re.search(r'id="payload">(.*?)</script>', text, re.DOTALL)
    assert found
    replay: dict[str, Any] = json.loads(found[1])["replays"][0]
    return replay


def colours(frame: Any, canvas: str) -> int:
    """Count the colours on a canvas: one if nothing is drawn."""
    count: int = frame.evaluate(
        """(canvas) => { const all = document.querySelector(canvas);
        const { data } = all.getContext('2d').getImageData(0, 0, all.width, all.height);
        return new Set(new Uint32Array(data.buffer)).size; }""",
        canvas,
    )
    return count


@each_pitfall
def test_replays_open_where_it_goes_wrong_and_play(
    open_pitfall: Open, pages: Path, pitfall: Pitfall
) -> None:
    page = open_pitfall(pitfall.name)
    titles = page.locator("iframe").evaluate_all("(all) => all.map((frame) => frame.title)")
    assert len(titles) == len(set(titles)) == len(pitfall.nodes)
    for node in pitfall.nodes:
        assert any(f"{node}.py" in title for title in titles)
        frame = open_frame(page, node)
        moments = payload_of(pages, node)["moments"]
        start = moments[0]["t"] if moments else 0.0
        assert bool(moments) == (node in pitfall.wrong)
        assert frame.evaluate("window.replayPlayer.time") == pytest.approx(start)
        assert frame.locator(".annotation").is_visible() == bool(moments)
        assert colours(frame, "canvas.map") > 5
        assert colours(frame, "canvas.plot") > 5
        frame.locator("canvas.map").focus()
        page.keyboard.press("Space")
        assert frame.evaluate("window.replayPlayer.playing")
        frame.evaluate("window.replayPlayer.advance(0.3)")
        page.keyboard.press("Space")
        assert not frame.evaluate("window.replayPlayer.playing")
        assert frame.evaluate("window.replayPlayer.time") >= start + 0.3


@pytest.mark.parametrize("viewport", [DESK, TELEPHONE], ids=["desk", "telephone"])
def test_frames_fit_and_nothing_is_wider_than_the_screen(
    open_pitfall: Open, viewport: dict[str, int]
) -> None:
    page = open_pitfall("no_stop_without_model", viewport=viewport)
    frame = open_frame(page, "no_stop_without_model_wrong")
    height, inner = frame.evaluate("[document.documentElement.scrollHeight, innerHeight]")
    assert abs(height - inner) <= 1
    assert frame.evaluate("document.documentElement.scrollWidth <= innerWidth")
    assert page.evaluate("document.documentElement.scrollWidth") <= viewport["width"]


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_replays_follow_the_reader_s_choice_of_light_or_dark(
    open_pitfall: Open, scheme: str
) -> None:
    page = open_pitfall("twist_stamped", color_scheme=scheme)
    frame = open_frame(page, "twist_stamped_wrong")
    dark = "getComputedStyle(document.body).backgroundColor.match(/\\d+/g).map(Number)[0] < 60"
    wait_until(frame, dark if scheme == "dark" else f"!({dark})")
    for theme, is_dark in (("dark", True), ("light", False), ("auto", scheme == "dark")):
        page.evaluate(f"document.body.dataset.theme = '{theme}'")
        wait_until(frame, dark if is_dark else f"!({dark})")


def test_a_command_that_is_no_number_leaves_a_gap_in_the_plot(
    open_pitfall: Open, pages: Path
) -> None:
    frame = open_frame(open_pitfall("nan_through_clip"), "nan_through_clip_wrong")
    moment = payload_of(pages, "nan_through_clip_wrong")["moments"][0]["t"]
    before, after = frame.evaluate(
        """(moment) => { // pixels of the commanded speed, before the moment and after it
          const canvas = document.querySelector('canvas.plot');
          const { width, height } = canvas;
          const scale = width / canvas.clientWidth;
          const { duration } = window.replayPlayer;
          const x = (t) => Math.round((44 + (canvas.clientWidth - 56) * t / duration) * scale);
          const { data } = canvas.getContext('2d').getImageData(0, 0, width, height);
          const count = (from, to) => {
            let found = 0;
            for (let row = Math.round(24 * scale); row < height / 2; row += 1)
              for (let i = 4 * (row * width + from); i < 4 * (row * width + to); i += 4)
                found += data[i] - data[i + 2] > 30;
            return found;
          };
          return [count(x(1), x(moment - 0.5)), count(x(moment + 0.5), x(2 * moment))]; }""",
        moment,
    )
    assert before > 100
    assert after == 0
