"""The lesson's site in a real browser, offline; axe-core has nothing against any kind of page."""

from pathlib import Path
from typing import Any

import pytest

ENDS = ("pitfalls/index", "pitfalls/front_by_index", "pitfalls/nan_through_clip", "search")
KINDS = ("index", "loop", "models", "real_time", "next", "check_your_understanding", "tier2",
         "turtlebot", "gpu", "glossary", "exercises/index", "exercises/trend_memory/README",
         "exercises/trend_memory/hints", *ENDS)  # fmt: skip
DESK, TELEPHONE = {"width": 1280, "height": 900}, {"width": 390, "height": 844}


@pytest.mark.long
@pytest.mark.parametrize(
    ("scheme", "size"), [("light", DESK), ("dark", DESK), ("light", TELEPHONE)]
)
def test_pages_have_no_violations(
    browser: Any, site: Path, axe: Any, scheme: str, size: dict[str, int]
) -> None:
    page = browser.new_page(reduced_motion="reduce", color_scheme=scheme, viewport=size)
    found = {}
    for name in KINDS:
        page.goto((site / f"{name}.html").as_uri())
        page.evaluate("document.querySelectorAll('details').forEach((e) => { e.open = true; })")
        page.evaluate("new Promise((done) => requestAnimationFrame(() => setTimeout(done)))")
        found[name] = axe(page)
        assert page.evaluate("document.documentElement.scrollWidth") <= size["width"], name
    page.close()
    assert {name: violations for name, violations in found.items() if violations} == {}


def test_the_search_for_violations_finds_them(browser: Any, axe: Any) -> None:
    page = browser.new_page()
    page.set_content("<title>x</title><h1>x</h1><img src='data:,'><p style='color:#eee'>faint</p>")
    found = axe(page)
    page.close()
    assert any(line.startswith("image-alt") for line in found)
    assert any(line.startswith("color-contrast") for line in found)


@pytest.mark.long
def test_every_page_opens_without_a_complaint(open_file: Any, site: Path) -> None:
    """Those with replays: tests/browser/test_pitfall_pages.py, test_acts.py and test_lite.py."""
    page = open_file(site / "why.html", offline=True)
    names = [file.relative_to(site).with_suffix("").as_posix() for file in site.rglob("*.html")]
    elsewhere = ("_", "index", "lite/", "pitfalls/", "search")
    for name in sorted(name for name in names if not name.startswith(elsewhere)):
        page.goto((site / f"{name}.html").as_uri())
        assert page.locator("article").inner_text().strip(), name


def test_on_paper_all_is_open_and_the_answers_stand_last(open_file: Any, site: Path) -> None:
    page = open_file(site / "node.html")
    page.locator(".option[data-right]").first.click()
    page.emulate_media(media="print")
    page.evaluate("window.dispatchEvent(new Event('beforeprint'))")
    assert page.locator("article details:not([open]):not(.look)").count() == 0
    asked = page.locator("article [data-answer]").count()
    assert asked == page.locator(".ask, .look > summary").count() > 2
    assert page.locator(".answers > div").count() == asked
    told = page.locator(".answers").inner_text()
    for right in page.locator(".option[data-right]").all():
        assert right.inner_text() in told
        assert "\u2713" not in right.evaluate("(e) => getComputedStyle(e, '::before').content")
    assert page.locator(".feedback:visible, .look[open]").count() == 0
    assert page.evaluate("document.querySelector('article').lastChild.className") == "answers"
    page.evaluate("window.dispatchEvent(new Event('afterprint'))")
    assert page.locator(".answers").count() == 0
    assert page.locator("article details[open]").count() == 0


def test_a_question_is_printed_beside_its_box(open_file: Any, site: Path) -> None:
    page = open_file(site / "check_your_understanding.html")
    page.emulate_media(media="print")
    boxes = page.locator(".own-answer").all()
    assert len(boxes) == 5
    for box in boxes:
        together = "(e) => getComputedStyle(e.closest('section')).breakInside"
        assert box.evaluate(together) == "avoid"


@pytest.mark.parametrize("name", ["loop", "real_time"])
def test_on_a_desk_no_listing_is_cut_off(open_file: Any, site: Path, name: str) -> None:
    page = open_file(site / f"{name}.html", viewport={"width": 1440, "height": 900})
    page.evaluate("document.querySelectorAll('details').forEach((e) => { e.open = true; })")
    wider = "(all) => all.filter((e) => e.scrollWidth > e.clientWidth + 1).map((e) => e.innerText)"
    assert page.locator(".highlight-python pre").evaluate_all(wider) == []
    assert page.evaluate("document.documentElement.scrollWidth") <= 1440


def test_search_finds_a_section(open_file: Any, site: Path) -> None:
    page = open_file(site / "search.html")
    page.goto((site / "search.html").as_uri() + "?q=percentile")
    hit = page.locator("ul.search li a", has_text="Keeping up with real time")
    hit.first.wait_for()  # they come one by one


def test_a_wide_table_is_read_on_a_telephone_without_scrolling_it(
    open_file: Any, site: Path
) -> None:
    page = open_file(site / "exercises" / "slow_model" / "README.html", viewport=TELEPHONE)
    cells = page.locator("table.is-wide").first.locator("tbody tr").first.get_by_role("cell")
    names = [cell.get_attribute("data-name") for cell in cells.all()]
    assert names == ["Topic", "Type", "Your node", "Content"]
    wider = "(all) => all.filter((box) => box.scrollWidth > box.clientWidth + 1).length"
    assert page.locator(".table-wrapper").evaluate_all(wider) == 0


def test_a_replay_that_never_came_leaves_no_blank_page(open_file: Any, site: Path) -> None:
    page = open_file(site / "pitfalls" / "reliable_only.html", may_complain=True)  # no replays
    page.emulate_media(media="print")
    page.evaluate("window.dispatchEvent(new Event('beforeprint'))")
    assert page.locator("figure.replay figcaption").first.is_visible()
    assert not page.locator("figure.replay iframe").first.is_visible()
