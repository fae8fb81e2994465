"""The lesson's site as students get it: nothing in it is an answer."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from grader.authoring.leaks import leaks
from grader.course.exercises import EXERCISES

pytestmark = pytest.mark.long


@pytest.fixture
def handed_out(site: Path, tmp_path: Path) -> Path:
    """A release's folder with the site and the skeletons."""
    shutil.copytree(site, tmp_path / "lesson")
    for file in EXERCISES.glob("*/*.py"):
        (tmp_path / "exercises" / file.parent.name).mkdir(parents=True, exist_ok=True)
        shutil.copyfile(file, tmp_path / "exercises" / file.parent.name / file.name)
    return tmp_path


def test_no_page_has_a_piece_of_a_solution_or_mutant(handed_out: Path) -> None:
    assert [str(leak) for leak in leaks(handed_out) if not leak.earlier] == []


def test_a_solution_that_a_page_includes_is_found(handed_out: Path, site: Path) -> None:
    """As Sphinx renders it: coloured, with numbered lines."""
    from pygments import highlight  # noqa: PLC0415
    from pygments.formatters import HtmlFormatter  # noqa: PLC0415
    from pygments.lexers import PythonLexer  # noqa: PLC0415

    solution = EXERCISES.parent / "solutions" / "goal_seeking" / "goal_seeking_agent.py"
    shown = highlight(solution.read_text("utf-8"), PythonLexer(), HtmlFormatter(linenos="inline"))
    page = handed_out / "lesson" / "state.html"
    page.write_text(page.read_text("utf-8").replace("</article>", f"{shown}</article>"), "utf-8")
    found = {leak.solution for leak in leaks(handed_out) if leak.file == "lesson/state.html"}
    assert {"", "solutions/goal_seeking/goal_seeking_agent.py"} <= found
