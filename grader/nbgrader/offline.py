"""nbgrader's feedback and formgrader pages without a network, and without what students smuggle in.

nbgrader's templates load MathJax from a CDN whatever `HTMLExporter.mathjax_url` says, since they
call their macro without it. In `templates/` that macro is empty, and formulas become MathML, which
every browser renders. Tables in lists, which nbconvert leaves as typed, become tables.

Markdown and code are rendered in a process with limits (`rclpy_virtual_time/link/cell.py`), and
what comes out is sanitised there by nh3: no scripts, forms or styles, links to the web only, and no
pictures but those that were pasted. What takes too long is shown as it was typed.
"""

import re
import time
from collections.abc import Callable, Mapping
from html import escape
from html.parser import HTMLParser
from importlib.resources import files
from pathlib import Path
from typing import Any

import nh3
from docutils.utils.math.latex2mathml import tex2mathml
from jinja2 import pass_context
from mistune.plugins.table import table_in_list
from nbconvert.filters import Highlight2HTML
from nbconvert.filters.markdown_mistune import IPythonRenderer, MarkdownWithMath
from pygments.token import STANDARD_TYPES

from grader.nbgrader.intake import PICTURES
from rclpy_virtual_time import FileReader

TEMPLATES = Path(__file__).parent / "templates"
MAX_FORMULA = 2_000  # [characters]; a longer one stays as it was typed
READER = FileReader(cpu=2, answer=64 << 20)  # of a notebook's cell
PAGE = 20.0  # [s] of CPU time for the cells of a page; an honest notebook takes less than one
TAG = 0.0002  # [s] that nbconvert takes for a tag of the page, in nbgrader's own process
MAX_TAGS = 10_000
MAX_DEPTH = 100  # of tags in one another: nbconvert takes the square of it

LANGUAGES = (
    "ipython3", "python", "pycon", "bash", "console", "cpp", "c", "yaml", "json", "xml", "text",
)  # fmt: skip

# --- what may be on a page -----------------------------------------------------------------------

MATHML = {
    "math", "menclose", "merror", "mfrac", "mi", "mn", "mo", "mover", "mphantom",
    "mroot", "mrow", "mspace", "msqrt", "mstyle", "msub", "msubsup", "msup", "mtable", "mtd",
    "mtext", "mtr", "munder", "munderover",
}  # fmt: skip
LAYOUT = {  # nothing that moves a formula up, over what is the page's own
    "accent", "accentunder", "columnalign", "columnspacing", "display", "displaystyle",
    "fence", "form", "linebreak", "linethickness", "lspace", "mathvariant", "maxsize",
    "minsize", "movablelimits", "notation", "rowspacing", "rspace", "scriptlevel", "separator",
    "stretchy", "symmetric", "width",
}  # fmt: skip
TAGS = (nh3.ALLOWED_TAGS - {"area", "map"}) | MATHML
ATTRIBUTES = {
    **nh3.ALLOWED_ATTRIBUTES,
    **dict.fromkeys(MATHML, LAYOUT),
    **{f"h{level}": {"id"} for level in range(1, 7)},
    **{tag: nh3.ALLOWED_ATTRIBUTES[tag] | {"style"} for tag in ("td", "th")},
}
CLASSES = {
    "div": {"highlight"},
    "span": {name for name in STANDARD_TYPES.values() if name},
    "a": {"anchor-link"},
}
EMPTY = {"br", "col", "hr", "img", "wbr"}  # without an end
PREFIX = "answer-"  # of ids: none is one of the page's own
SPACE = re.compile(r"-?\d?(\.\d+)?em")  # as TeX's, less than ten letters
LINK = re.compile(r"https?://|mailto:", re.IGNORECASE)
PASTED = tuple(f"data:{kind};base64," for kind in PICTURES)


def sanitised(page: str) -> str:
    """Return HTML without anything that a browser would run, fetch, or take for the page's own.

    Raises FileReader.Refused: its tags are too many, or nested too deep.
    """
    clean = nh3.clean(
        page,
        tags=TAGS,
        clean_content_tags={"script", "style"},
        attributes=ATTRIBUTES,
        attribute_filter=_kept,
        allowed_classes=CLASSES,
        filter_style_properties={"text-align"},
        url_schemes={"http", "https", "mailto", "data"},
        id_prefix=PREFIX,
    )
    _Depth().feed(clean)
    return clean


class _Depth(HTMLParser):
    """Refuses tags that are nested too deep, or too many."""

    depth = count = 0

    def handle_starttag(self, tag: str, attrs: object) -> None:
        self.count += 1
        if self.count > MAX_TAGS:
            raise FileReader.Refused(f"its HTML has more than {MAX_TAGS:,} tags")
        self.depth += tag not in EMPTY
        if self.depth > MAX_DEPTH:
            raise FileReader.Refused(f"its HTML is nested deeper than {MAX_DEPTH} tags")

    def handle_endtag(self, tag: str) -> None:
        self.depth -= tag not in EMPTY


def _kept(tag: str, name: str, value: str) -> str | None:
    if name == "src":
        return value if value.startswith(PASTED) else None
    if name == "href":
        if value.startswith("#"):
            return f"#{PREFIX}{value[1:]}"
        return value if LINK.match(value) else None
    if tag in MATHML and name in ("width", "lspace"):
        return value if SPACE.fullmatch(value) else None
    return None if name == "cite" else value


# --- nbgrader's filters --------------------------------------------------------------------------


def work_offline(config: Any) -> None:
    """Let nbgrader's pages load nothing from the network."""
    theirs = files("nbgrader") / "server_extensions" / "formgrader" / "templates"
    config.HTMLExporter.extra_template_basedirs = [str(TEMPLATES), str(theirs)]
    config.HTMLExporter.filters = {
        "markdown2html": markdown2html,
        "highlight_code": highlight_code,
        "strip_files_prefix": as_it_is,  # nbconvert's takes the text's length squared
    }


@pass_context
def markdown2html(context: Any, source: str) -> str:
    """Return Markdown as HTML, as nbconvert does, with MathML for formulas, and sanitised."""
    attachments = context.get("cell", {}).get("attachments", {})
    return _rendered(context, page_of, source, {name: dict(a) for name, a in attachments.items()})


@pass_context
def highlight_code(context: Any, source: str, **_: Any) -> str:
    """Return Python as HTML, as nbconvert does."""
    return _rendered(context, highlighted, source)


def as_it_is(page: str) -> str:
    """Return a page unchanged: no link of it begins with "files/"."""
    return page


def _rendered(context: Any, work: Callable[..., str], source: str, *more: Any) -> str:
    page = context.get("resources")
    spent = page.get("course_spent", 0.0) if isinstance(page, dict) else 0.0
    took = float(READER.cpu)  # at most
    try:
        if spent > PAGE:
            raise FileReader.Refused(f"the page takes more than {PAGE:g} s")
        made, took = READER.read(timed, work.__name__, source, *more, returns=tuple[str, float])
    except FileReader.Refused as refused:
        why = f"This cell is shown as it was typed: {refused}."
        made = f"<p><em>{escape(why)}</em></p><pre>{escape(source)}</pre>"
    if isinstance(page, dict):
        page["course_spent"] = spent + took + TAG * made.count("<")
    return made


# --- in the cell ---------------------------------------------------------------------------------


def timed(work: str, *arguments: Any) -> tuple[str, float]:
    """Return what a function below makes, and the CPU time that it took [s]."""
    begin = time.process_time()
    made = page_of(*arguments) if work == page_of.__name__ else highlighted(*arguments)
    return made, time.process_time() - begin


def page_of(source: str, attachments: Mapping[str, Mapping[str, str]]) -> str:
    """Return Markdown as sanitised HTML, in this process."""
    renderer = _Renderer(escape=False, attachments=dict(attachments))
    markdown = MarkdownWithMath(renderer=renderer)
    markdown.use(table_in_list)  # the tasks of an exercise are a list, with tables in it
    return sanitised(markdown.render(source))


def highlighted(source: str) -> str:
    """Return Python as HTML, in this process."""
    return sanitised(Highlight2HTML()(source))


class _Renderer(IPythonRenderer):  # type: ignore[misc]
    """nbconvert's renderer, except for formulas and pictures."""

    def block_math(self, body: str) -> str:
        return _mathml(body, block=True) or str(super().block_math(body))

    def inline_math(self, body: str) -> str:
        return _mathml(body, block=False) or str(super().inline_math(body))

    def latex_environment(self, name: str, body: str) -> str:
        formula = f"\\begin{{{name}}}{body}\\end{{{name}}}"
        return _mathml(formula, block=True) or str(super().latex_environment(name, body))

    def image(self, text: str, url: str, title: str | None = None) -> str:
        """Return a picture that was pasted as PNG, JPEG or GIF; of others, what they are called."""
        forms = self.attachments.get(url.removeprefix("attachment:"), {})
        if url.startswith("attachment:") and set(PICTURES) & set(forms):
            return str(super().image(text, url, title))
        name = url[:100] + ("…" if url[100:] else "")
        return f"<em>(picture {escape(name)}: not shown; only pasted PNG, JPEG and GIF are)</em>"

    def block_code(self, code: str, info: str | None = None) -> str:
        """Return code, with colours if its language is one that can be loaded here."""
        try:
            return str(super().block_code(code, info))
        except Exception:  # a cell reads no files, so no rare lexer's
            return f"<pre><code>{escape(code)}</code></pre>\n"


def _mathml(formula: str, *, block: bool) -> str:
    """Return a formula as MathML; "" if it can't be converted: students write what they like."""
    if len(formula) > MAX_FORMULA:
        return ""
    try:
        made: str = tex2mathml(formula.strip(), as_block=block)
    except Exception:  # docutils' MathError, and whatever else an odd formula makes it raise
        return ""
    return made


def warm_up() -> None:
    """Load what rendering needs: in the cell nothing can be imported."""
    for language in LANGUAGES:
        page_of(f"# a\n\n```{language}\nx\n```\n$\\frac{{a}}{{b}}$ [b](https://c)\n", {})
    highlighted("x = 1")
