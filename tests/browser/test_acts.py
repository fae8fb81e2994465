"""What the lesson's pages do: questions, wrong lines, answers, replays, figures, progress."""

import re
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from frames import value, wait_until

from grader.authoring.lesson_replays import LESSONS, write
from rclpy_virtual_time.link.hosts import ForkServer

Open = Callable[..., Any]
PAGES = sorted(f.stem for f in LESSONS.glob("*.md") if ":::{question}" in f.read_text("utf-8"))


@pytest.fixture(scope="module")
def lesson(site: Path, forkserver: ForkServer, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of the built pages, with the replays of the lesson."""
    copy = Path(shutil.copytree(site, tmp_path_factory.mktemp("site") / "html"))
    write(copy / "replays", forkserver)
    return copy


def test_a_question_answers_back_and_is_remembered(open_file: Open, site: Path) -> None:
    page = open_file(site / "why.html")
    assert not page.locator(".feedback").first.is_visible()
    for option in page.locator(".option").all():
        option.press("Enter")
        assert option.locator("xpath=../div").is_visible()
    assert page.locator(".option.is-right").count() == 1
    assert page.locator(".question .status").text_content()
    page.locator(".said a").click()
    assert page.evaluate("document.querySelector('.said-here:target').textContent").strip()
    page.reload()
    assert page.locator(".option.is-right").count() == 1
    assert page.locator(".option.is-wrong").count() == 0
    assert "is-done" in page.locator(".sidebar-tree a.current").first.get_attribute("class")


@pytest.mark.parametrize("name", PAGES)
def test_every_question_leads_to_the_sentence_that_answers_it(
    open_file: Open, site: Path, name: str
) -> None:
    page = open_file(site / f"{name}.html")
    asked = page.locator(".question").count()
    assert asked == page.locator(".option[data-right]").count() == page.locator(".said a").count()
    assert asked >= 1
    for link in page.locator(".said a").all():
        target = link.get_attribute("href")
        assert page.locator(target).count() == 1


def test_what_follows_waits_for_a_guess(open_file: Open, site: Path) -> None:
    page = open_file(site / "pitfalls" / "front_by_index.html", may_complain=True)  # no replays
    colour = "getComputedStyle(document.querySelector('.hll')).backgroundColor"
    before = page.evaluate(colour)
    assert not page.locator("#why").is_visible()
    page.locator("#line").fill("14")
    page.locator("#line").press("Enter")
    assert page.locator("#why").is_visible()
    assert page.locator(".challenge .status").inner_text().startswith("Right: lines 14")
    assert page.evaluate(colour) != before


def test_no_pitfall_marks_its_line_before_a_guess(open_file: Open, site: Path) -> None:
    for file in (LESSONS / "pitfalls").glob("*.md"):
        if file.stem != "index":
            page = open_file(site / "pitfalls" / f"{file.stem}.html", may_complain=True)
            colours = page.locator(".hll").evaluate_all(
                "lines => lines.map(line => getComputedStyle(line).backgroundColor)"
            )
            assert set(colours) == {"rgba(0, 0, 0, 0)"}, file.name


def test_the_lines_asked_for_are_those_marked() -> None:
    for file in (LESSONS / "pitfalls").glob("*.md"):
        text = file.read_text("utf-8")
        marked = re.findall(r"(?m)^:emphasize-lines: (.+)$", text)
        assert marked == re.findall(r"(?m)^```\{challenge\} (.+)$", text), file.name


def test_a_model_answer_comes_after_one_s_own(open_file: Open, site: Path) -> None:
    page = open_file(site / "check_your_understanding.html")
    assert page.locator(".own-answer").count() == page.locator(".model-answer").count() == 5
    assert not page.locator(".model-answer").first.is_visible()
    page.locator("textarea").first.fill("A callback gets the scan, decides, and publishes a speed.")
    assert page.locator(".model-answer").first.is_visible()
    page.reload()
    assert page.locator("textarea").first.input_value().startswith("A callback")


@pytest.mark.parametrize("motion", ["reduce", "no-preference"])
def test_the_robot_of_the_front_page_drives(open_file: Open, lesson: Path, motion: str) -> None:
    page = open_file(lesson / "index.html", reduced_motion=motion)
    frame = page.locator("iframe").element_handle().content_frame()
    wait_until(frame, "window.replayPlayer")
    assert value(frame, "playing") == (motion != "reduce")
    assert not frame.locator(".plot-box").is_visible()
    assert frame.locator(".play-button").is_visible()
    if motion != "reduce":
        value(frame, f"advance({value(frame, 'duration')})")
        assert value(frame, "playing")  # from the start again


def test_a_replay_comes_when_it_is_asked_for(open_file: Open, lesson: Path) -> None:
    page = open_file(lesson / "models.html", viewport={"width": 390, "height": 844})
    assert page.locator("iframe").count() == 0
    page.locator("details:has(button.watch) > summary").press("Enter")  # one looks after a guess
    page.locator("button.watch").press("Enter")
    frame = page.locator("iframe").element_handle().content_frame()
    wait_until(frame, "window.replayPlayer")
    assert page.evaluate("document.documentElement.scrollWidth") <= 390


def test_figures_are_played_by_keyboard(open_file: Open, site: Path) -> None:
    page = open_file(site / "real_time.html")
    figure = page.locator('[data-play="queue"]')
    verdict = figure.locator(".verdict")
    assert "1.10 s old" in verdict.inner_text()
    figure.locator('input[type="range"]').nth(2).press("Home")  # a queue of one
    assert "0.20 s old" in verdict.inner_text()
    figure.locator("summary").press("Enter")
    assert figure.locator("table tr").count() > 10
    page.evaluate("document.querySelectorAll('details').forEach((e) => { e.open = true; })")
    for button in page.locator(".play button").all():
        assert button.bounding_box()["height"] >= 44
