"""From the class report to two replays side by side; a class of 500; axe-core on both."""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import classes
import payloads
import pytest

from grader.classroom.amendments import Entry, Undo, Waive
from grader.classroom.results import ResultOptions, write_results
from grader.classroom.row import StoredResult
from grader.lms.book import StudentRow
from grader.lms.people import Person
from grader.report.page import page_html

SLUG = "obstacle_avoidance"
MOST = 400_000  # [bytes] of the class report of 500


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A class whose replays are synthetic, and whose sections are two."""
    out = tmp_path_factory.mktemp("class")
    results, options = classes.whole_class()
    rows = {
        one.student: StudentRow(one.student, Person("", "AB"[index % 2]))
        for index, one in enumerate(results)
    }
    results = [replace(one, recordings=Path("recordings")) for one in results]
    log = [
        Entry(1, "2026-05-04T09:12:00+00:00", "prof", Waive(SLUG, "blind"), classes.HOSTILE),
        Entry(2, "2026-05-04T09:13:00+00:00", "prof", Undo(1), "a slip"),
    ]
    write_results(results, out, replace(options, students=rows, log=log))
    for page in (out / "feedback").glob(f"*/{SLUG}.html"):
        page.write_text(page_html(payloads.failing_page() | {"title": page.parent.name}))
    return out


@pytest.fixture
def open_file(browser: Any) -> Iterator[Callable[..., Any]]:
    contexts, complaints = [], []

    def open_(file: Path, **options: Any) -> Any:
        settings = {"viewport": {"width": 1400, "height": 900}, "reduced_motion": "reduce"}
        context = browser.new_context(**settings | options)
        contexts.append(context)
        page = context.new_page()
        page.on("console", lambda message: complaints.append(message.text))
        page.on("pageerror", lambda error: complaints.append(str(error)))
        page.goto(file.as_uri())
        return page

    yield open_
    for context in contexts:
        context.close()
    assert complaints == []


def test_the_most_failed_check_leads_to_its_replays(
    open_file: Callable[..., Any], folder: Path
) -> None:
    page = open_file(folder / "class.html")
    page.locator(f"#exercise-{SLUG} tbody a").first.click()
    check = page.url.rpartition("/")[2].removesuffix(".html")
    assert page.locator("h1").inner_text()
    names = page.locator("tbody th[scope=row]").all_inner_texts()
    assert len(names) > 2
    frames = [page.frame(name=side) for side in ("left", "right")]
    titles = [frame.locator("h1").inner_text() for frame in frames]
    assert titles[0] != titles[1]
    other = next(name for name in names if name in classes.NAMES and name not in titles)
    page.get_by_role("link", name=f"{other} on the right").click()
    page.frame_locator("[name=right]").locator("h1", has_text=other).wait_for()
    assert page.frame(name="right").url.endswith(f"#check={check}")
    assert page.frame(name="left").locator("h1").inner_text() == titles[0]
    page.get_by_role("link", name="Class report").click()
    assert page.url.endswith(f"class.html#exercise-{SLUG}")


def test_a_frame_opens_at_the_moment_of_its_check(
    open_file: Callable[..., Any], tmp_path: Path
) -> None:
    made = payloads.failing_page()
    moments = [moment for run in made["replays"] for moment in run["moments"]]
    wanted = moments[-1]
    file = tmp_path / "report.html"
    file.write_text(page_html(made))
    page = open_file(tmp_path / "report.html")
    page.goto(f"{file.as_uri()}#check={wanted['check']}")
    page.reload()
    assert page.locator(".score").count() == 0
    assert f"{wanted['t']:.2f}" in page.locator("body").inner_text()
    page.goto(f"{file.as_uri()}#check=no_such_check")
    page.reload()
    assert page.locator("canvas.map").is_visible()


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("width", [360, 1400])
def test_axe_has_nothing_to_say(
    open_file: Callable[..., Any], folder: Path, axe: Callable[[Any], list[str]], scheme: str,
    width: int,
) -> None:  # fmt: skip
    pages = [folder / "class.html"]
    pages += sorted((folder / "checks" / SLUG).iterdir())[:1]
    for file in pages:
        size = {"width": width, "height": 900}
        page = open_file(file, color_scheme=scheme, bypass_csp=True, viewport=size)
        assert axe(page) == []
        assert page.evaluate("document.documentElement.scrollWidth") <= width


def test_a_class_of_500_is_one_page_of_a_fair_size(
    open_file: Callable[..., Any], tmp_path: Path
) -> None:
    chance = random.Random(2)
    results: list[StoredResult] = [
        classes.stored(f"student-{number:03}", slug, classes.grading(slug, chance.gauss(), chance))
        for number in range(500)
        for slug in (SLUG, "goal_seeking")
    ]
    assert not write_results(results, tmp_path, ResultOptions()).missing
    assert (tmp_path / "class.html").stat().st_size < MOST
    page = open_file(tmp_path / "class.html")
    assert page.locator("#students tbody tr").count() == 500
    assert "500 students" in page.locator("header").inner_text()
