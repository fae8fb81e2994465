"""nbgrader's pages need no network: no script from elsewhere, and formulas that show themselves."""

import functools
import itertools
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import nbgrader
import pytest
from html_pages import Page
from nbconvert.exporters import HTMLExporter
from nbformat import NotebookNode, v4
from traitlets.config import Config

from grader.nbgrader import configure, offline
from grader.nbgrader.intake import Cell
from grader.nbgrader.offline import MAX_FORMULA, highlighted, page_of
from grader.nbgrader.restore import MAX_PROSE, restored
from grader.notebook.build import built, text_of
from rclpy_virtual_time import FileReader

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

    @functools.cache
    def exporter(template: str) -> HTMLExporter:
        config = Config()
        configure(config)
        config.HTMLExporter.template_name = template
        config.HTMLExporter.extra_template_paths = [str(CSS)]  # as GenerateFeedback does
        config.Exporter.default_preprocessors = []
        return HTMLExporter(config=config)

    def render_(notebook: NotebookNode, template: str) -> str:
        page, _ = exporter(template).from_notebook_node(notebook, dict(PLACE))
        return str(page)

    return render_


def graded() -> NotebookNode:
    """A notebook of the course with formulas, as it is after grading."""
    notebook = built(text_of("04_memory"))
    for cell in notebook.cells:
        if "nbgrader" in cell.metadata:
            cell.metadata.nbgrader |= {"score": 1.0, "comment": "Well done: $v < 0$."}
    return notebook


def answer(*texts: str, **more: object) -> NotebookNode:
    return v4.new_notebook(cells=[v4.new_markdown_cell(text, **more) for text in texts])


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


def test_no_formula_is_drawn_over_the_pages_own_words() -> None:
    moved = "<mpadded voffset='300px' height='0' lspace='-99em'><mtext>20/20</mtext></mpadded>"
    spaces = "<mspace width='-500em'/><mspace width='-0.1667em'/>"
    assert offline.sanitised(f"<math>{moved}{spaces}</math>") == (
        '<math><mtext>20/20</mtext><mspace></mspace><mspace width="-0.1667em"></mspace></math>'
    )


# --- what a page would run -----------------------------------------------------------------------

EVIL = [
    "<script>steal()</script>",
    "<img src=x onerror=steal()>",
    "a <b onclick=steal()>b</b>",
    "<!-- --><svg/onload=steal()>",
    "[click](javascript:steal())",
    "[click]( JaVaScRiPt:steal())",
    "[click]\n(javascript:steal())",
    "[click](<javascript:steal()>)",
    "[click](data:text/html,steal())",
    "[click][x]\n\n[x]: javascript:steal()",
    "> [x]: javascript:steal()\n\n[x]",
    "<javascript:steal()>",
    "![p](https://example.org/steal.png)",
    "![p][x]\n\n[x]: https://example.org/steal.png",
    r"$\href{javascript:steal()}{x}$",
    r"$$\style{position:fixed}{x} \require{html}$$",
    "\x00[x](javascript:steal())",
    "]\x00(javascript:steal())",
    "[attachment](attachment:x)(javascript:steal())",
    "- [x]: javascript:steal()\n\n[My answer][x]",
    "> - [x]: javascript:steal()\n\n[My answer][x]",
    "[a\nb]: javascript:steal()\n\n[My answer][a b]",
    "[x](vbscript:steal()) [y](//example.org/steal) [z](/logout) [w](\\tjava\nscript:steal())",
    "![p](/logout) ![q](javascript:steal()) <img src=/logout> <img src=data:image/svg+xml,x>",
    "<math><mtext><table><mglyph><style><!--</style><img title='--&gt;&lt;img onerror=1&gt;'>",
    "<svg><p><style><g title='</style><img src=x onerror=steal()>'>",
    "<form action=/formgrader><input name=x><button>grade</button></form>",
    "<details open ontoggle=steal()>x</details><video src=x><source onerror=steal()></video>",
    "<a href='jav&#x09;ascript:steal()'>x</a> <base href=//example.org> <meta http-equiv=refresh>",
    "<div style='position:fixed;inset:0' class='modal-backdrop' id=toolbar>over the page</div>",
    "<iframe srcdoc='<script>steal()</script>'></iframe><object data=x></object><embed src=x>",
    "# toolbar\n\n<h1 id=toolbar>x</h1>",
    "```x' onmouseover='steal()\ny\n```",
    "```mermaid\n<script>steal()</script>\n```",
    "$$x$$<script>steal()</script>$$",
    "<noscript><p title='</noscript><img src=x onerror=steal()>'>",
    "<textarea></textarea><img src=x onerror=steal()></textarea>",
]
LINKS = re.compile(r"https?://|mailto:|#answer-|data:image/(png|jpeg|gif);base64,")
LIVE = {
    "script", "svg", "iframe", "style", "object", "embed", "form", "base", "meta", "input",
    "button", "link", "video", "source", "textarea", "noscript",
}  # fmt: skip


def live(body: str) -> list[object]:
    """Return what a browser would run or fetch, or take for the page's own."""
    page = Page(body)
    found: list[object] = [tag for tag in page.tags if tag in LIVE]
    for tag, name, value in page.attributes:
        odd = {"href": not LINKS.match(value), "src": not value.startswith("data:image/")}
        odd |= {"style": not value.startswith("text-align"), "id": not value.startswith("answer-")}
        odd |= {"class": value in ("modal-backdrop", "mermaid")}
        found += [(tag, name, value)] if name.startswith("on") or odd.get(name) else []
    return found


@pytest.mark.parametrize("template", TEMPLATES)
def test_nothing_that_a_student_writes_runs_in_the_instructors_browser(
    render: Render, template: str
) -> None:
    kinds = ("markdown", "raw", "code")
    evil = EVIL if template == "feedback" else EVIL[::5]  # the filters are the same
    cells = [Cell(kind, f"Before {text}") for text in evil for kind in kinds]
    made = restored([*cells, *(Cell("markdown", text) for text in evil)], [])
    page = render(made, template)
    for text in evil:
        shown = page_of(text, {}), highlighted(text)
        assert [live(each) for each in shown] == [[], []], text
    assert page.count(EVIL[0]) == 0
    assert "onerror=steal" not in re.sub(r"(?s)<pre>.*?</pre>", "", page)


def test_the_test_itself_sees_what_runs() -> None:
    assert all(live(text) for text in EVIL[:4])


PASTED = {
    "missing": {},
    "svg": {"image/svg+xml": "PHN2Zy8+"},
    "webp": {"image/webp": "UklGRg=="},
    "nothing": {},
}


@pytest.mark.parametrize("name", PASTED)
def test_a_picture_that_is_missing_or_of_another_kind_is_a_line_of_text(
    render: Render, name: str
) -> None:
    attachments = {f"{name}.x": PASTED[name]} if name != "missing" else {}
    look = answer(f"Look: ![plot](attachment:{name}.x)", attachments=attachments)
    page = render(look, "feedback")
    assert f"(picture attachment:{name}.x: not shown" in page


def test_a_pasted_picture_is_shown(render: Render) -> None:
    pasted = {"a.png": {"image/png": "iVBORw0KGgo="}}
    page = render(answer("![plot](attachment:a.png)", attachments=pasted), "feedback")
    assert 'src="data:image/png;base64,iVBORw0KGgo="' in page


def test_honest_text_looks_the_same() -> None:
    text = (
        "It is **late** if $a < b$ and x < 3; see [ROS](https://docs.ros.org) or [below](#x).\n\n"
        "> a quote\n\n| a | b |\n|---|:-:|\n| 1 | `x` |\n\n```python\na[0](1)\n```\n"
        "<details><summary>Hint</summary>\n\nThis.\n</details>"
    )
    page = Page(page_of(text, {}))
    assert {"strong", "math", "a", "blockquote", "td", "code", "details", "summary"} <= {*page.tags}
    assert ("a", "href", "https://docs.ros.org") in page.attributes
    assert ("td", "style", "text-align:center") in page.attributes
    assert "".join(page.texts).count("x < 3") == 1


SLOW = {
    "brackets": "[" * 50_000,
    "brackets and links": "[a](" * 25_000,
    "emphasis": "*a _b " * 16_000,
    "quotes": ">" * 20_000 + "x",
    "lists": "".join(f"{' ' * depth}- x\n" for depth in range(400)),
    "backticks": "".join("`" * n + "x" for n in range(400)),
    "entities": "&" * 100_000,
    "tags": "<a " * 30_000,
    "pictures": "![" * 50_000,
    "references": "".join(f"[{n}]: x\n" for n in range(8_000)),
    "tables": "|a" * 30_000 + "\n" + "|-" * 30_000 + "\n",
    "formulas": "$" * 100_000,
    "environments": "\\begin{a}" * 10_000,
    "nested html": "<div>" * 2_000,
}


def test_a_page_of_text_that_takes_long_is_made(
    render: Render, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(offline, "READER", replace(offline.READER, cpu=1))
    cells = [v4.new_markdown_cell(text[:MAX_PROSE]) for text in SLOW.values()]
    page = render(v4.new_notebook(cells=[*cells, v4.new_code_cell("f(" * 20_000)]), "feedback")
    assert "takes more than 1 s of CPU time" in page
    assert page.count("shown as it was typed") >= 2
    with pytest.raises(FileReader.Refused, match="nested deeper"):
        page_of("<div>" * 200, {})


def test_a_page_of_slow_cells_is_made_all_the_same(
    render: Render, monkeypatch: pytest.MonkeyPatch
) -> None:
    notebook = answer("a **b**", "c **d**")
    clock = SimpleNamespace(monotonic=itertools.count(100, 100).__next__)  # a busy machine's
    monkeypatch.setattr(offline, "time", clock)
    assert "as it was typed" not in render(notebook, "feedback")
    monkeypatch.setattr(offline, "PAGE", 0.0)
    page = render(notebook, "feedback")
    assert "a <strong>b</strong>" in page
    assert "shown as it was typed: the page takes more than 0 s" in page
    assert "c **d**" in page
