"""nbgrader's pages need no network: no script from elsewhere, and formulas that show themselves."""

import re
from collections.abc import Callable
from pathlib import Path

import nbformat
import nbgrader
import pytest
from html_pages import Page
from nbconvert.exporters import HTMLExporter
from nbformat import NotebookNode, v4
from traitlets.config import Config

from grader.nbgrader import configure
from grader.nbgrader.offline import MAX_FORMULA
from grader.notebook.build import source_of

STATIC = Path(nbgrader.__file__).parent / "server_extensions" / "formgrader" / "static"
CSS = STATIC / "node_modules" / "bootstrap" / "dist" / "css"
PLACE = {  # what nbgrader tells its templates
    "nbgrader": {"notebook": "04_memory", "score": 1.0, "max_score": 2.0, "late_penalty": 0},
    "base_url": "", "index": 0, "total": 1, "submission_id": "s", "notebook_id": "n",
    "assignment_id": "a", "notebook_path": "p",
}  # fmt: skip
TEMPLATES = ("feedback", "formgrade")
Render = Callable[[NotebookNode, str], str]


def loads(body: str) -> list[str]:
    """Return what a page fetches from elsewhere; links are only for clicking."""
    page = Page(body)
    names = ("src", "srcset", "href", "data", "poster")
    found = [value for tag, name, value in page.attributes if tag != "a" and name in names]
    for text in page.texts:
        found += re.findall(r"(?:url\(|@import|from|import)\s*['\"(]*([^'\")\s;]+)", text)
    return [value for value in found if re.match(r"(?i)\s*(https?:)?//", value)]


@pytest.fixture(scope="module")
def render() -> Render:
    """nbgrader's exporters, as the course's configuration sets them up."""

    def render_(notebook: NotebookNode, template: str) -> str:
        config = Config()
        configure(config)
        config.HTMLExporter.template_name = template
        config.HTMLExporter.extra_template_paths = [str(CSS)]  # as GenerateFeedback does
        config.Exporter.default_preprocessors = []
        page, _ = HTMLExporter(config=config).from_notebook_node(notebook, dict(PLACE))
        return str(page)

    return render_


def graded() -> NotebookNode:
    """A notebook of the course with formulas, as it is after grading."""
    notebook = nbformat.read(source_of("04_memory"), as_version=4)
    for cell in notebook.cells:
        if "nbgrader" in cell.metadata:
            cell.metadata.nbgrader |= {"score": 1.0, "comment": "Well done: $v < 0$."}
    return notebook


def answer(text: str) -> NotebookNode:
    return v4.new_notebook(cells=[v4.new_markdown_cell(text)])


@pytest.mark.parametrize("template", TEMPLATES)
def test_nothing_is_asked_of_the_network_and_formulas_are_mathml(
    render: Render, template: str
) -> None:
    page = render(graded(), template)
    assert loads(page) == []
    assert "cdn" not in page
    assert page.count("<math") >= 3
    assert "<mfrac>" in page
    assert "\\frac" not in page


def test_the_search_finds_what_nbgrader_loads_by_itself(render: Render) -> None:
    config = Config()
    templates = Path(nbgrader.__file__).parent / "server_extensions" / "formgrader" / "templates"
    config.HTMLExporter.template_name = "feedback"
    config.HTMLExporter.extra_template_basedirs = [str(templates)]
    config.HTMLExporter.extra_template_paths = [str(CSS)]
    page, _ = HTMLExporter(config=config).from_notebook_node(graded(), dict(PLACE))
    assert any("mathjax" in load for load in loads(page))


@pytest.mark.parametrize("template", TEMPLATES)
def test_tables_in_the_list_of_tasks_are_tables(render: Render, template: str) -> None:
    tasks = "1. **Act.**\n\n   | What | Speed |\n   |---|---|\n   | blind | 0.0 m/s |\n2. Next."
    page = render(answer(tasks), template)
    assert page.count("<td>") == 2
    assert "<li><p>Next" in page or "<li>Next" in page
    assert "|---" not in page


ODD = {
    "unknown": "$\\unknown{x}$",
    "link": "$\\href{javascript:steal()}{x}$",
    "deep": "$" + "{" * 1500 + "$",
    "long": "$" + "x" * (MAX_FORMULA + 1) + "$",
    "tag": "$<img src=x onerror=steal()>$",
    "script": "$\\text{<script>steal()</script>}$",
    "environment": "$$\\begin{align}\\end$$",
    "odd characters": "$\x00\ud7ff$",
}


@pytest.mark.parametrize("formula", ODD)
def test_an_odd_formula_harms_nobody(render: Render, formula: str) -> None:
    page = render(answer(f"Before {ODD[formula]} after"), "feedback")
    shown = page[page.index("Before") : page.index("after")]
    assert set(re.findall(r"<(\w+)", shown)) <= {
        "math", "mi", "mo", "mn", "mrow", "mtext", "mtable", "mtr", "mtd", "mfrac", "p",
    }  # fmt: skip
    assert not re.search(r"<[^>]*(href|onerror|javascript)", shown)
