"""A button below each `course drive` of a page that lets its program drive in the browser.

The program is the listing of that name, on the page itself or on the only other page that has one.
A pitfall's node can be mended below the question which of its lines is wrong. Only where the site
is built with the workspace, and for programs and commands that run there: its plan.json says what
can be imported, which scenarios there are, and which options are refused.
"""

from __future__ import annotations

import ast
import html
import json
import shlex
import tomllib
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from docutils import nodes

if TYPE_CHECKING:
    from collections.abc import Iterator

    from sphinx.application import Sphinx
    from sphinx.environment import BuildEnvironment

PROMPT = "$ course drive "
THREADS = {"threading", "_thread", "concurrent", "MultiThreadedExecutor"}  # what needs them
PITFALLS = Path(__file__).resolve().parents[1] / "pitfalls" / "pitfalls.toml"
ACTS = {"drive": "Drive it here", "mend": "Mend it here"}


class Listing(NamedTuple):
    """A program that a page shows."""

    page: str
    file: str
    text: str


def taken(text: str) -> tuple[set[str], set[str]]:
    """Return the modules that a program imports, and the names that it takes out of them."""
    modules, names = set(), set()
    for part in ast.walk(ast.parse(text)):
        if isinstance(part, ast.Import):
            modules |= {alias.name.partition(".")[0] for alias in part.names}
        elif isinstance(part, ast.ImportFrom):
            modules.add((part.module or "").partition(".")[0])
            names |= {alias.name for alias in part.names}
    return modules, names


def needs_threads(text: str) -> bool:
    """Return whether a program starts threads."""
    modules, names = taken(text)
    return bool((modules | names) & THREADS)


def runs_there(text: str, words: list[str], here: dict[str, Any]) -> bool:
    """Return whether a program with these arguments can be driven in the page.

    `here` has the `modules`, the `scenarios` and the `refused` options of the workspace.
    """
    if not taken(text)[0] <= set(here["modules"]):
        return False
    options = {word.partition("=")[0] for word in words}
    given = words[words.index("--scenario") + 1 :] if "--scenario" in words else []
    return bool(given) and given[0] in here["scenarios"] and not options & set(here["refused"])


# --- what the pages show --------------------------------------------------------------------------


def collect(app: Sphinx, doctree: nodes.document) -> None:
    """Note a page's listings."""
    kept: dict[str, list[Listing]] = _listings(app.env)
    kept[app.env.docname] = list(listings(doctree, app.env.docname))


def listings(doctree: nodes.document, page: str) -> Iterator[Listing]:
    """Yield the programs of a page: Python with a caption, and whole files that it includes."""
    for block in doctree.findall(nodes.literal_block):
        if block.get("language") != "python":
            continue
        captions = [each.astext() for each in block.parent.findall(nodes.caption)]
        source = Path(block.get("source") or "")
        name = captions[0] if captions and "literal_block" in block.parent else source.name
        if name.endswith(".py"):
            yield Listing(page, name, f"{block.astext().rstrip()}\n")


def _listings(env: BuildEnvironment) -> dict[str, list[Listing]]:
    if not hasattr(env, "course_listings"):
        env.course_listings = {}  # type: ignore[attr-defined]
    found: dict[str, list[Listing]] = env.course_listings  # type: ignore[attr-defined]
    return found


def forget(_app: Sphinx, env: BuildEnvironment, page: str) -> None:
    """Forget a page's listings before it is read again."""
    _listings(env).pop(page, None)


def merge(_app: Sphinx, env: BuildEnvironment, pages: set[str], other: BuildEnvironment) -> None:
    """Take over what another process has read."""
    _listings(env).update({page: _listings(other)[page] for page in pages})


# --- the buttons ----------------------------------------------------------------------------------


def add_places(app: Sphinx, doctree: nodes.document, page: str) -> None:
    """Put the places of buttons into a page; `workspace/web/page.js` makes the buttons."""
    if not app.config.course_workspace_made or app.builder.format != "html":
        return
    plan = json.loads(Path(app.config.course_workspace, "plan.json").read_text("utf-8"))
    for after, file, words, act in [*_commands(doctree), *_mended(doctree, page)]:
        shown = _shown(app.env, page, file)
        if shown is None or not runs_there(shown.text, words, plan["drives"]):
            continue
        several = words[words.index("--scenario") + 1] in plan["drives"]["several"]
        threads = " data-threads" if several or needs_threads(shown.text) else ""
        place = (
            f'<p class="drive-here" data-page="{shown.page}" data-file="{html.escape(file)}" '
            f'data-arguments="{html.escape(shlex.join(words))}" data-act="{ACTS[act]}" '
            f'data-code="{html.escape(shown.text)}"{threads}></p>'
        )
        after.parent.insert(after.parent.index(after) + 1, nodes.raw("", place, format="html"))


def _commands(doctree: nodes.document) -> Iterator[tuple[nodes.Element, str, list[str], str]]:
    """Yield for each command what its button follows, the file, the arguments, the act."""
    for block in list(doctree.findall(nodes.literal_block)):
        if block.get("language") != "console" or not block.astext().startswith(PROMPT):
            continue
        words = shlex.split(block.astext().removeprefix(PROMPT).replace("\\\n", " "))
        after = block.next_node(siblings=True, descend=False)
        shows = isinstance(after, nodes.literal_block) and after.get("language") == "output"
        yield (after if shows else block), words[0], words[1:], "drive"


def _mended(
    doctree: nodes.document, page: str
) -> Iterator[tuple[nodes.Element, str, list[str], str]]:
    """Yield the same for a pitfall's question, which comes below its first node."""
    pitfalls = tomllib.loads(PITFALLS.read_text("utf-8"))
    about = pitfalls.get(page.removeprefix("pitfalls/"))
    forms = [raw for raw in doctree.findall(nodes.raw) if 'class="challenge"' in raw.astext()]
    if about and forms:
        yield forms[0], f"{about['wrong'][0]}.py", ["--scenario", about["scenario"]], "mend"


def _shown(env: BuildEnvironment, page: str, file: str) -> Listing | None:
    """Return the listing of that name: the page's last, or that of the only page with one."""
    every = _listings(env)
    own = [each for each in every.get(page, []) if each.file == file]
    others = [each for listed in every.values() for each in listed if each.file == file]
    if own:
        return own[-1]
    return others[0] if len(others) == 1 else None


def add_script(
    app: Sphinx, _n: str, _t: str, _p: dict[str, Any], doctree: nodes.document | None
) -> None:
    """Give a page with such places what makes them work."""
    if doctree is not None and any(
        'class="drive-here"' in raw.astext() for raw in doctree.findall(nodes.raw)
    ):
        app.add_css_file("workspace/workspace.css")
        app.add_js_file("workspace/start.js", loading_method="defer")


def setup(app: Sphinx) -> dict[str, Any]:
    """Tell Sphinx."""
    app.connect("doctree-read", collect)
    app.connect("env-purge-doc", forget)
    app.connect("env-merge-info", merge)
    app.connect("doctree-resolved", add_places)
    app.connect("html-page-context", add_script)
    return {"parallel_read_safe": True, "parallel_write_safe": True, "env_version": 1}
