"""axe-core finds nothing to complain about in any kind of page of the site, light or dark."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from lesson_pages import ROOT

pytestmark = pytest.mark.long
ENDS = ("pitfalls/index", "pitfalls/front_by_index", "pitfalls/nan_through_clip", "search")
KINDS = ("index", "loop", "models", "real_time", "next", "check_your_understanding", "tier2", "gpu",
         "glossary", "exercises/index", "exercises/trend_memory/README",
         "exercises/trend_memory/hints", *ENDS)  # fmt: skip
DESK, TELEPHONE = {"width": 1280, "height": 900}, {"width": 390, "height": 844}


@pytest.fixture(scope="module")
def context(browser: Any) -> Iterator[Any]:
    context = browser.new_context(reduced_motion="reduce")
    yield context
    context.close()


@pytest.mark.parametrize(
    ("scheme", "size"), [("light", DESK), ("dark", DESK), ("light", TELEPHONE)]
)
def test_pages_have_no_violations(
    context: Any, site: Path, axe: Any, scheme: str, size: dict[str, int]
) -> None:
    page = context.new_page()
    page.emulate_media(color_scheme=scheme)
    page.set_viewport_size(size)
    found = {}
    for name in KINDS:
        page.goto((site / f"{name}.html").as_uri())
        page.evaluate("document.querySelectorAll('details').forEach((e) => { e.open = true; })")
        page.evaluate("new Promise((done) => requestAnimationFrame(() => setTimeout(done)))")
        found[name] = axe(page)
    assert {name: violations for name, violations in found.items() if violations} == {}


def test_the_search_for_violations_finds_them(context: Any, axe: Any) -> None:
    page = context.new_page()
    page.set_content("<title>x</title><h1>x</h1><img src='data:,'><p style='color:#eee'>faint</p>")
    found = axe(page)
    assert any(line.startswith("image-alt") for line in found)
    assert any(line.startswith("color-contrast") for line in found)


def test_folded_answers_and_code_are_printed_whole(context: Any, site: Path) -> None:
    page = context.new_page()
    page.goto((site / "real_time.html").as_uri())
    page.emulate_media(media="print")
    page.evaluate("window.dispatchEvent(new Event('beforeprint'))")
    seen = page.evaluate(
        """() => ({
          folded: document.querySelectorAll('article details:not([open])').length,
          cut: [...document.querySelectorAll('article .highlight pre')]
            .filter((e) => e.scrollWidth > e.clientWidth + 1).length })"""
    )
    assert seen == {"folded": 0, "cut": 0}
    page.evaluate("window.dispatchEvent(new Event('afterprint'))")
    assert page.locator("article details[open]").count() == 0


def test_every_skeleton_is_one_click_away(context: Any, site: Path) -> None:
    page = context.new_page()
    for folder in sorted(file.parent for file in ROOT.glob("exercises/*/exercise.toml")):
        page.goto((site / "exercises" / folder.name / "README.html").as_uri())
        offered = {
            Path(link.get_attribute("href")).name: (
                site / "exercises" / folder.name / link.get_attribute("href")
            )
            for link in page.locator("article a.download").all()
        }
        assert set(offered) == {file.name for file in folder.glob("*.py")}
        for name, file in offered.items():
            assert file.read_text("utf-8") == (folder / name).read_text("utf-8")
