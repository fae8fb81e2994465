"""An instructor's formgrader, as nbgrader serves it: marks and tables are the judge's.

One submission is graded by the command, the other by the formgrader's own button.
"""

import re
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("nbformat", reason="nbformat is not installed (the extra `notebooks`)")

from lab_server import Server, picture, serving, tab
from nbgrader_kit import (
    FULL,
    cell_named,
    fill,
    grades,
    hand_in,
    make_course,
    nbgrader,
    released,
    solution,
    total,
)

from grader.claims.mutants import find_mutant
from grader.course.exercises import find_exercise

LACKS = [name for name in ("jupyterlab", "nbgrader") if find_spec(name) is None]
pytestmark = [
    pytest.mark.skipif(bool(LACKS), reason=f"not installed: {LACKS} (the extra `notebooks`)"),
    pytest.mark.skipif(not FULL, reason="formgrader in a browser: make notebooks"),
]
NAME = "01_loop"
QUIZ = "quiz"
SLUG = "obstacle_avoidance"
FILE = "obstacle_avoidance_agent.py"
MISTAKE = "narrow_cone"  # one of exercise 1's mutants: it fails one check of 10 points
WIDE = {"viewport": {"width": 1280, "height": 1000}}


@pytest.fixture(scope="module")
def course(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Ada's notebook has a mistake and is graded; Ben's is right and not graded yet."""
    folder = make_course(tmp_path_factory.mktemp("course"), [NAME, QUIZ])
    mutant = find_mutant(find_exercise(SLUG), MISTAKE)
    texts = {"ada": mutant.text, "ben": solution(SLUG, FILE)}
    for student, text in texts.items():
        hand_in(folder, student, NAME, fill(released(folder, NAME), {FILE: text}))
    quiz = released(folder, QUIZ)
    cell_named(quiz, "quiz-1")["source"] = "Perception, decision, action."
    hand_in(folder, "ada", QUIZ, quiz)
    nbgrader(folder, "autograde", NAME, "--student", "ada")
    nbgrader(folder, "autograde", QUIZ)
    nbgrader(folder, "generate_feedback", NAME)
    return folder


@pytest.fixture(scope="module")
def server(course: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    with serving(course, tmp_path_factory.mktemp("jupyter")) as running:
        yield running


@pytest.fixture
def page(browser: Any, server: Server) -> Iterator[Any]:
    with tab(browser, server, **WIDE) as opened:
        opened.page.goto(server.address("formgrader/manage_assignments"))
        yield opened.page


def row(page: Any, text: str) -> Any:
    """The row of a table that has this text, once it is loaded."""
    found = page.locator("table tbody tr", has_text=text)
    found.first.wait_for()
    assert found.count() == 1
    return found


def test_the_button_grades_as_the_command_does(page: Any, course: Path, server: Server) -> None:
    page.goto(server.address(f"formgrader/manage_submissions/{NAME}"))
    assert row(page, "ada").locator(".score").inner_text() == "90 / 100"
    assert "needs autograding" in row(page, "ben").inner_text()

    row(page, "ben").locator(".autograde a").click()
    page.locator("#success-modal, #error-modal").wait_for()

    assert page.locator("#error-modal").count() == 0, page.locator("#error-modal").inner_text()
    page.get_by_role("button", name=re.compile("Close")).first.click()
    score = page.locator("table tbody tr", has_text="ben").locator(".score", has_text="/")
    score.wait_for()
    assert score.inner_text() == "100 / 100"
    assert total(grades(course), "ben", SLUG) == 100
    assert total(grades(course), "ada", SLUG) == 90


def test_a_submission_is_listed_and_shows_the_judges_table(
    page: Any, course: Path, server: Server
) -> None:
    link = page.get_by_role("link", name="Manual Grading", exact=True)
    link.first.click()
    page.get_by_role("link", name=NAME, exact=True).click()
    page.get_by_role("link", name=NAME, exact=True).click()
    listed = row(page, f"{total(grades(course), 'ada', SLUG):g} / 100")
    listed.locator("a:visible").first.click()

    failed = page.locator(".output_html table, .jp-RenderedHTML table").filter(has_text="FAIL")
    failed.first.wait_for()
    assert failed.count() == 1
    text = failed.inner_text()
    assert "✗ FAIL" in text
    assert "✓ pass" in text
    assert "expected" in text
    page.wait_for_function("() => document.activeElement.matches('.tabbable')")  # the first answer
    scores = page.locator("input.score")
    page.wait_for_function(
        "() => [...document.querySelectorAll('input.score')].every((e) => e.value || e.placeholder)"
    )
    values = scores.evaluate_all("(all) => all.map((e) => e.value || e.placeholder)")
    assert sum(map(float, values)) == total(grades(course), "ada", SLUG)
    failed.evaluate("(e) => e.scrollIntoView({block: 'center'})")
    picture(page, "formgrader", {"x": 60, "y": 0, "width": 1160, "height": 880})


def test_the_mark_scheme_stands_above_the_answer(page: Any, server: Server) -> None:
    page.goto(server.address(f"formgrader/gradebook/{QUIZ}/{QUIZ}"))
    row(page, "0 / 15").locator("a:visible").first.click()

    scheme = page.locator(".text_cell_render, .jp-RenderedMarkdown").filter(
        has_text="Mark scheme (students don't get it)"
    )
    scheme.first.wait_for()
    assert scheme.count() == 5
    assert scheme.first.locator("table tr").count() == 4
    answer = page.get_by_text("Perception, decision, action.")
    assert scheme.first.bounding_box()["y"] < answer.bounding_box()["y"]
    page.locator("input.score").nth(4).wait_for()
    picture(page, "formgrader-quiz")
