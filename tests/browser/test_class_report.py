"""The class report and the students' pages in a real browser, down to two replays side by side."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import classes
import payloads
import pytest

from grader.classroom.amendments.change import Undo, Waive
from grader.classroom.amendments.log import Entry
from grader.classroom.results.options import ResultOptions
from grader.classroom.results.write import write_results
from grader.report.page import page_html

OpenFile = Callable[..., Any]
SLUG = "obstacle_avoidance"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A class whose replays are synthetic."""
    out = tmp_path_factory.mktemp("class")
    results, options = classes.whole_class()
    log = [
        Entry(1, "2026-05-04T09:12:00+00:00", "prof", Waive(SLUG, "blind"), classes.HOSTILE),
        Entry(2, "2026-05-04T09:13:00+00:00", "prof", Undo(1), "a slip"),
    ]
    results = [replace(one, recordings=Path("recordings")) for one in results]
    write_results(results, out, replace(options, log=log))
    for page in (out / "feedback").glob(f"*/{SLUG}.html"):
        page.write_text(page_html(payloads.failing_page() | {"title": page.parent.name}))
    return out


def test_the_report_says_what_a_professor_asks(open_file: OpenFile, folder: Path) -> None:
    page = open_file(folder / "class.html")
    text = page.locator("body").inner_text()
    for part in (
        "28 students",
        "the worker died three times",
        "the machine stood still for 2.4 s",
        "canary goal_seeking/mutant/turns_the_long_way",
        "Checks, the most failed first",
        "python 3.11.2",
    ):
        assert part in text
    histogram = page.get_by_role("img", name="Histogram of 27 scores")
    assert "from 90 to 100" in histogram.get_attribute("aria-label")


def test_hostile_text_stays_text(open_file: OpenFile, folder: Path) -> None:
    page = open_file(folder / "class.html")
    assert page.evaluate("window.pwned") is None
    assert page.locator("img").count() == page.locator("script").count() == 0
    assert page.locator("style").count() == 1
    assert "<img src=x onerror" in page.locator("#notes").inner_text()


def test_every_link_leads_somewhere(open_file: OpenFile, folder: Path) -> None:
    page = open_file(folder / "class.html")
    ids = page.evaluate("[...document.querySelectorAll('[id]')].map((e) => e.id)")
    links = page.evaluate("[...document.querySelectorAll('a')].map((a) => a.getAttribute('href'))")
    assert {link[1:] for link in links if link.startswith("#")} <= set(ids)
    files = [link.partition("#")[0] for link in links if not link.startswith("#")]
    assert len(files) > 60
    assert [link for link in files if not (folder / unquote(link)).is_file()] == []


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("width", [360, 1280])
def test_axe_has_nothing_to_say(
    open_file: OpenFile, folder: Path, axe: Callable[[Any], list[str]], scheme: str, width: int
) -> None:
    own = folder / "feedback" / "ada"
    pages = [folder / "class.html", own / "index.html", own / "goal_seeking.html"]
    for file in pages:
        size = {"width": width, "height": 900}
        page = open_file(file, color_scheme=scheme, bypass_csp=True, viewport=size)
        assert axe(page) == []
        assert page.evaluate("document.documentElement.scrollWidth") <= width


def test_a_frame_opens_at_the_moment_of_its_check(open_file: OpenFile, tmp_path: Path) -> None:
    made = payloads.failing_page()
    wanted = [moment for run in made["replays"] for moment in run["moments"]][-1]
    file = tmp_path / "report.html"
    file.write_text(page_html(made))
    page = open_file(file)
    page.goto(f"{file.as_uri()}#check={wanted['check']}")
    page.reload()
    assert page.locator(".score").count() == 0
    assert f"{wanted['t']:.2f}" in page.locator("body").inner_text()
    page.goto(f"{file.as_uri()}#check=no_such_check")
    page.reload()
    assert page.locator("canvas.map").is_visible()


def test_a_student_finds_the_page_of_an_exercise(open_file: OpenFile, folder: Path) -> None:
    page = open_file(folder / "feedback" / "ada" / "index.html")
    assert page.locator("h1").inner_text() == "ada"
    page.get_by_role("link", name="3 · Goal seeking").click()
    assert page.locator("h1").inner_text() == "Goal seeking: ada"
    text = page.locator("body").inner_text()
    assert "/srv" not in text
    assert "There is no run to replay." in text


def test_a_held_student_reads_that_nothing_is_lost(open_file: OpenFile, folder: Path) -> None:
    page = open_file(folder / "feedback" / "ben" / "index.html")
    assert "A person has to look at this one" in page.locator("main").inner_text()
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
