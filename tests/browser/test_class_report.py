"""The class report and the students' pages in a real browser."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import classes
import pytest

from grader.classroom.results import ResultOptions, write_results

OpenFile = Callable[..., Any]
CONTRAST = """() => {
  // the least contrast (WCAG 2.2, "contrast ratio") of any text that is seen
  const canvas = document.createElement('canvas').getContext('2d', { willReadFrequently: true });
  const rgba = (colour) => { canvas.clearRect(0, 0, 1, 1); canvas.fillStyle = colour;
    canvas.fillRect(0, 0, 1, 1); return [...canvas.getImageData(0, 0, 1, 1).data]; };
  const light = ([r, g, b]) => { const [x, y, z] = [r, g, b].map((v) => v / 255)
    .map((v) => (v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4));
    return 0.2126 * x + 0.7152 * y + 0.0722 * z; };
  const behind = (e) => { for (; e; e = e.parentElement) {
    const colour = rgba(getComputedStyle(e).backgroundColor);
    if (colour[3] === 255) return colour; }
    return [255, 255, 255, 255]; };
  let least = [99, ''];
  const texts = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (texts.nextNode()) {
    const e = texts.currentNode.parentElement;
    if (!texts.currentNode.textContent.trim() || !e.checkVisibility()) continue;
    const style = getComputedStyle(e);
    const ink = light(rgba(e instanceof SVGElement ? style.fill : style.color));
    const page = light(behind(e));
    const ratio = (Math.max(ink, page) + 0.05) / (Math.min(ink, page) + 0.05);
    if (ratio < least[0]) least = [ratio, e.outerHTML.slice(0, 120)];
  }
  return least;
}"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("class")
    results, options = classes.whole_class()
    write_results(results, out, options)
    return out


@pytest.fixture
def open_file(browser: Any) -> Iterator[OpenFile]:
    """Open a file; at the end nothing may have been complained about or requested elsewhere."""
    contexts, complaints, requests = [], [], []

    def open_(file: Path, **options: Any) -> Any:
        context = browser.new_context(**{"viewport": {"width": 1280, "height": 800}} | options)
        contexts.append(context)
        page = context.new_page()
        page.on("console", lambda message: complaints.append(message.text))
        page.on("pageerror", lambda error: complaints.append(str(error)))
        page.on("request", lambda request: requests.append(request.url))
        page.goto(file.as_uri())
        return page

    yield open_
    for context in contexts:
        context.close()
    assert complaints == []
    assert [url for url in requests if not url.startswith(("file:", "data:"))] == []


def test_the_report_says_what_a_professor_asks(open_file: OpenFile, folder: Path) -> None:
    page = open_file(folder / "class.html")
    text = page.locator("body").inner_text()
    for part in (
        "28 students",
        "the worker died three times",
        "the machine stood still for 2.4 s",
        "canary goal_seeking/mutant/turns_the_long_way",
        "identical but for names and layout",
        "Separates well.",
        "python 3.11.2",
    ):
        assert part in text
    histogram = page.get_by_role("img", name="Histogram of 27 scores")
    assert "from 90 to 100" in histogram.get_attribute("aria-label")
    similar = page.get_by_role("table", name="Groups of submissions").first
    assert similar.locator("li").all_inner_texts() == ["fatima", "lena", "tomas"]


@pytest.mark.parametrize("width", [360, 768, 1280, 1920])
@pytest.mark.parametrize("name", ["class.html", "feedback/ada/index.html"])
def test_nothing_is_wider_than_the_screen(
    open_file: OpenFile, folder: Path, name: str, width: int
) -> None:
    page = open_file(folder / name, viewport={"width": width, "height": 800})
    assert page.evaluate("document.documentElement.scrollWidth") <= width


def test_hostile_text_stays_text(open_file: OpenFile, folder: Path) -> None:
    page = open_file(folder / "class.html")
    assert page.evaluate("window.pwned") is None
    assert page.locator("img").count() == page.locator("script").count() == 0
    assert page.locator("style").count() == 1
    assert "<img src=x onerror" in page.locator("#notes").inner_text()


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("width", [390, 1280])
def test_text_can_be_read(open_file: OpenFile, folder: Path, scheme: str, width: int) -> None:
    size = {"width": width, "height": 800}
    page = open_file(folder / "class.html", color_scheme=scheme, viewport=size)
    ratio, where = page.evaluate(CONTRAST)
    assert ratio >= 4.5, where  # WCAG 2.2, 1.4.3
    background = page.evaluate("getComputedStyle(document.body).backgroundColor.match(/\\d+/g)[0]")
    assert (int(background) < 60) == (scheme == "dark")


def test_headings_tables_and_links_have_their_order_and_names(
    open_file: OpenFile, folder: Path
) -> None:
    page = open_file(folder / "class.html")
    levels = page.evaluate("[...document.querySelectorAll('h1,h2,h3')].map((e) => +e.tagName[1])")
    assert levels[0] == 1
    assert levels.count(1) == 1
    assert all(after - before <= 1 for before, after in pairwise(levels))
    assert page.evaluate(
        """[...document.querySelectorAll('table')].every((t) => t.caption.textContent.trim()
        && t.querySelectorAll('thead th[scope=col]').length
        && [...t.tBodies].every((b) => [...b.rows].every((r) => r.cells[0].tagName === 'TH')))"""
    )
    assert page.evaluate(
        "[...document.querySelectorAll('svg')].every((s) => s.getAttribute('aria-label'))"
    )
    ids = page.evaluate("[...document.querySelectorAll('[id]')].map((e) => e.id)")
    assert len(ids) == len(set(ids))
    targets = page.evaluate(
        "[...document.querySelectorAll('a[href^=\"#\"]')].map((e) => e.hash.slice(1))"
    )
    assert set(targets) <= set(ids)


def test_every_file_that_is_linked_is_there(open_file: OpenFile, folder: Path) -> None:
    page = open_file(folder / "class.html")
    links = page.evaluate(
        "[...document.querySelectorAll('a:not([href^=\"#\"])')].map((a) => a.href)"
    )
    assert len(links) > 60
    for link in links:
        assert Path(unquote(link.removeprefix("file://"))).is_file(), link


def test_the_keyboard_reaches_tables_that_scroll(open_file: OpenFile, folder: Path) -> None:
    page = open_file(folder / "class.html", viewport={"width": 360, "height": 800})
    overview = page.get_by_role("region", name="All exercises")
    overview.focus()
    assert page.evaluate("getComputedStyle(document.activeElement).outlineStyle") == "solid"
    assert overview.evaluate("(e) => e.scrollWidth > e.clientWidth")


def test_a_phone_reads_cards_and_a_screen_reader_still_a_table(
    open_file: OpenFile, folder: Path
) -> None:
    page = open_file(folder / "class.html", viewport={"width": 360, "height": 800})
    held = page.get_by_role("table", name="Held gradings")
    assert held.get_by_role("row").count() == 3
    assert held.get_by_role("columnheader").count() == 5
    label = "(e) => getComputedStyle(e, '::before').content"
    assert "What to do" in held.get_by_role("cell").nth(3).evaluate(label)


def test_it_prints_in_black_on_white_without_navigation(open_file: OpenFile, folder: Path) -> None:
    page = open_file(folder / "class.html", color_scheme="dark")
    page.emulate_media(media="print")
    assert not page.locator("nav").is_visible()
    assert page.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(255, 255, 255)"
    ratio, where = page.evaluate(CONTRAST)
    assert ratio >= 4.5, where
    assert len(page.pdf(format="A4")) > 10_000


def test_a_student_finds_the_page_of_an_exercise(open_file: OpenFile, folder: Path) -> None:
    page = open_file(folder / "feedback" / "ada" / "index.html")
    assert page.locator("h1").inner_text() == "ada"
    page.get_by_role("link", name="1 · Obstacle avoidance").click()
    assert page.locator("h1").inner_text() == "Obstacle avoidance: ada"
    text = page.locator("body").inner_text()
    assert "/srv" not in text
    assert "There is no run to replay." in text


def test_a_held_student_reads_that_nothing_is_lost(open_file: OpenFile, folder: Path) -> None:
    page = open_file(folder / "feedback" / "ben" / "index.html")
    text = page.locator("main").inner_text()
    assert "A person has to look at this one" in text
    assert page.get_by_role("link").count() == 1


def test_withheld_details_are_not_in_the_page_at_all(open_file: OpenFile, tmp_path: Path) -> None:
    results, _ = classes.whole_class()
    failing = next(r for r in results if r.grading and 0 < r.grading["score"] < 100)
    write_results([replace(failing, student="ada")], tmp_path, ResultOptions(hide="details"))
    page = open_file(tmp_path / "feedback" / "ada" / f"{failing.exercise}.html")
    assert "What this check saw is not published." in page.locator("main").inner_text()
    payload = page.evaluate("document.getElementById('payload').textContent")
    for word in ("avoid_zones", "4711", '"actual":"0', '"expected":"0', "wrong speed"):
        assert word not in payload
