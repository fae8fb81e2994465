"""nbgrader's feedback and formgrader pages without a network: formulas as MathML.

nbgrader's templates load MathJax from a CDN whatever `HTMLExporter.mathjax_url` says, since they
call their macro without it. In `templates/` that macro is empty, and formulas become MathML, which
every browser renders. Tables in lists, which nbconvert leaves as typed, become tables.
"""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path
from typing import Any

from docutils.utils.math.latex2mathml import tex2mathml
from jinja2 import pass_context
from mistune.plugins.table import table_in_list
from nbconvert.filters.markdown_mistune import IPythonRenderer, MarkdownWithMath

TEMPLATES = Path(__file__).parent / "templates"
MAX_FORMULA = 2_000  # [characters]; a longer one stays as it was typed


def work_offline(config: Any) -> None:
    """Let nbgrader's pages load nothing from the network."""
    theirs = files("nbgrader") / "server_extensions" / "formgrader" / "templates"
    config.HTMLExporter.extra_template_basedirs = [str(TEMPLATES), str(theirs)]
    config.HTMLExporter.filters = {"markdown2html": markdown2html}


@pass_context
def markdown2html(context: Any, source: str) -> str:
    """Return Markdown as HTML, as nbconvert does, with MathML for formulas."""
    attachments = context.get("cell", {}).get("attachments", {})
    renderer = _Renderer(escape=False, attachments=attachments)
    markdown = MarkdownWithMath(renderer=renderer)
    markdown.use(table_in_list)  # the tasks of an exercise are a list, with tables in it
    html: str = markdown.render(source)
    return html


class _Renderer(IPythonRenderer):  # type: ignore[misc]
    """nbconvert's renderer, except for formulas."""

    def block_math(self, body: str) -> str:
        return _mathml(body, block=True) or str(super().block_math(body))

    def inline_math(self, body: str) -> str:
        return _mathml(body, block=False) or str(super().inline_math(body))

    def latex_environment(self, name: str, body: str) -> str:
        formula = f"\\begin{{{name}}}{body}\\end{{{name}}}"
        return _mathml(formula, block=True) or str(super().latex_environment(name, body))


def _mathml(formula: str, *, block: bool) -> str:
    """Return a formula as MathML; "" if it can't be converted: students write what they like."""
    if len(formula) > MAX_FORMULA:
        return ""
    try:
        made: str = tex2mathml(formula.strip(), as_block=block)
    except Exception:  # docutils' MathError, and whatever else an odd formula makes it raise
        return ""
    return made
