"""The lesson's site in a real browser: light and dark, on a desk and on a telephone, offline."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from lesson_pages import PAGES

DESK, TELEPHONE = 1280, 390  # [px]
NAMES = [page.stem for page in PAGES] + ["exercises/trend_memory/README", "exercises/index"]
LOOK = """() => {
  // what a reader would stumble over, also in what has to be opened first
  document.querySelectorAll('details').forEach((e) => { e.open = true; });
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
  const found = { contrast: [99, ''], letters: [99, ''], overflow: 0, cut: [] };
  const article = document.querySelector('article');
  const texts = document.createTreeWalker(article, NodeFilter.SHOW_TEXT);
  while (texts.nextNode()) {
    const e = texts.currentNode.parentElement;
    if (!texts.currentNode.textContent.trim() || !e.checkVisibility()) continue;
    if (e.closest('style, title, desc, .headerlink, mspace')) continue;
    const drawing = e.closest('svg.drawing');
    const style = getComputedStyle(e);
    const ink = light(rgba(drawing ? style.fill : style.color));
    const page = light(behind(e));
    const ratio = (Math.max(ink, page) + 0.05) / (Math.min(ink, page) + 0.05);
    if (ratio < found.contrast[0]) found.contrast = [ratio, e.outerHTML.slice(0, 120)];
    const width = (d) => d.getBoundingClientRect().width;
    const scale = drawing ? width(drawing) / drawing.viewBox.baseVal.width : 1;
    const size = parseFloat(style.fontSize) * scale;
    if (size < found.letters[0]) found.letters = [size, e.outerHTML.slice(0, 120)];
    if (drawing) {
      const frame = drawing.getBoundingClientRect();
      const word = e.getBoundingClientRect();
      if (word.left < frame.left - 1 || word.right > frame.right + 1 ||
          word.top < frame.top - 1 || word.bottom > frame.bottom + 1)
        found.cut.push(e.textContent);
    }
  }
  found.overflow = document.documentElement.scrollWidth - window.innerWidth;
  return found;
}"""
OVERLAPS = """() => {
  // words of a figure that lie upon each other
  const found = [];
  for (const drawing of document.querySelectorAll('svg.drawing')) {
    const words = [...drawing.querySelectorAll('text')].map((e) => [e.textContent, e.getBBox()]);
    words.forEach(([a, p], i) => words.slice(i + 1).forEach(([b, q]) => {
      const wide = Math.min(p.x + p.width, q.x + q.width) - Math.max(p.x, q.x);
      const high = Math.min(p.y + p.height, q.y + q.height) - Math.max(p.y, q.y);
      if (wide > 1 && high > 4) found.push(a + ' / ' + b);
    }));
  }
  return found;
}"""


@pytest.fixture
def context(browser: Any) -> Iterator[Any]:
    """A browser that may complain about nothing and ask nobody for anything."""
    context = browser.new_context(viewport={"width": DESK, "height": 900})
    context.set_offline(True)
    complaints: list[str] = []
    context.on("console", lambda message: complaints.append(f"{message.type}: {message.text}"))
    context.on("weberror", lambda error: complaints.append(f"error: {error.error}"))
    asked: list[str] = []
    context.on("request", lambda request: asked.append(request.url))
    yield context
    context.close()
    assert [said for said in complaints if said.startswith(("error", "warning"))] == []
    assert [url for url in asked if not url.startswith(("file:", "data:"))] == []


@pytest.mark.parametrize(
    ("scheme", "width"),
    [("light", TELEPHONE), pytest.param("dark", DESK, marks=pytest.mark.long)],
)
def test_pages_can_be_read(context: Any, site: Path, scheme: str, width: int) -> None:
    page = context.new_page()
    page.emulate_media(color_scheme=scheme)
    page.set_viewport_size({"width": width, "height": 900})
    for name in NAMES:
        page.goto((site / f"{name}.html").as_uri())
        seen = page.evaluate(LOOK)
        assert seen["contrast"][0] >= 4.5, (name, seen["contrast"])
        assert seen["letters"][0] >= 12, (name, seen["letters"])
        assert seen["overflow"] <= 0, name
        assert seen["cut"] == [], name
        assert page.evaluate(OVERLAPS) == [], name
    background = page.evaluate("getComputedStyle(document.body).backgroundColor")
    assert (background == "rgb(255, 255, 255)") == (scheme == "light")


@pytest.mark.long
def test_every_other_page_opens_without_a_complaint(context: Any, site: Path) -> None:
    """Each exercise's page too. Those with replays: tests/browser/test_pitfall_pages.py."""
    page = context.new_page()
    names = [file.relative_to(site).with_suffix("").as_posix() for file in site.rglob("*.html")]
    elsewhere = ("_", "pitfalls/", "search")
    others = [name for name in sorted(names) if not name.startswith(elsewhere)]
    assert sum(name.startswith("exercises/") for name in others) >= 10
    for name in others:
        page.goto((site / f"{name}.html").as_uri())
        assert page.locator("article").inner_text().strip(), name


def test_the_switch_turns_figures_too(context: Any, site: Path) -> None:
    page = context.new_page()
    page.goto((site / "loop.html").as_uri())
    colour = "getComputedStyle(document.querySelector('svg.drawing text.blue')).fill"
    seen = {page.evaluate(colour)}
    for _ in range(3):
        page.locator(".theme-toggle:visible").first.click()
        seen.add(page.evaluate(colour))
    assert len(seen) == 2


def test_figures_are_read_aloud(context: Any, site: Path) -> None:
    page = context.new_page()
    page.goto((site / "real_time.html").as_uri())
    image = page.get_by_role("img", name="Sensor rate, model time and control rate")
    assert image.count() == 1


def test_search_finds_a_section(context: Any, site: Path) -> None:
    page = context.new_page()
    page.goto((site / "search.html").as_uri() + "?q=percentile")
    page.wait_for_selector("ul.search li")
    hits = page.locator("ul.search li a").all_inner_texts()
    assert "Keeping up with real time" in hits
