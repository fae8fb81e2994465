"""Build HTML pages that need neither scripts nor the network."""

from __future__ import annotations

import base64
import functools
import hashlib
from collections.abc import Iterable
from pathlib import Path
from xml.etree import ElementTree as ET

from grader.classroom.results.clean import one_line, visible
from grader.report.page import GENERATED_BY

TOKENS = Path(__file__).resolve().parents[2] / "report" / "player" / "tokens.css"
STYLE = Path(__file__).resolve().parent / "class.css"

Element = ET.Element
Child = Element | str | None


def el(tag: str, /, *children: Child | Iterable[Child], **attributes: object) -> Element:
    """Make an element; text in children is escaped.

    `class_` becomes class, `aria_label` aria-label; None and False leave an attribute out.
    """
    element = Element(tag)
    for key, value in attributes.items():
        if value is not None and value is not False:
            element.set(key.rstrip("_").replace("_", "-"), visible("" if value is True else value))
    add(element, *children)
    return element


def add(parent: Element, *children: Child | Iterable[Child]) -> Element:
    """Append elements and text."""
    for child in children:
        if child is None:
            continue
        if isinstance(child, str):
            _add_text(parent, visible(child))
        elif isinstance(child, Element):
            parent.append(child)
        else:
            add(parent, *child)
    return parent


def name(text: object, most: int = 60) -> Element:
    """Return a user-chosen name: one line, with its own writing direction."""
    return el("bdi", one_line(text, most), class_="name")


def table(
    caption: str,
    headings: Iterable[tuple[str, str]],
    bodies: Iterable[Element],
    class_: str = "",
    stacks: bool = False,
) -> Element:
    """Return a table with a caption and headings (text, class), in a box that scrolls sideways.

    One that `stacks` becomes a list of cards on a phone; its ARIA roles are explicit, since
    browsers drop the implicit ones with the layout.
    """
    headings = tuple(headings)
    columns = [el("th", text, scope="col", class_=style or None) for text, style in headings]
    grid = el(
        "table",
        el("caption", caption, class_="hidden-text"),
        el("thead", el("tr", columns)),
        *_bodies(bodies),
    )
    if stacks:
        class_ = f"{class_} stacks"
        _set_roles(grid, [text for text, _ in headings])
    # scrolls by keyboard, too (WCAG 2.1.1), so it is a named region
    return el(
        "div", grid, class_=f"table {class_}".strip(), role="region", aria_label=caption, tabindex=0
    )


def section(
    id_: str, heading: str, lead: str, *children: Child | Iterable[Child], class_: str = ""
) -> Element:
    """Return a section with a heading and an id to link to."""
    return el(
        "section",
        el("h2", heading, id=f"{id_}-heading"),
        el("p", lead, class_="lead") if lead else None,
        *children,
        id=id_,
        aria_labelledby=f"{id_}-heading",
        class_=f"block {class_}".strip(),
    )


def document(title: str, *body: Child | Iterable[Child], frames: bool = False) -> str:
    """Return the HTML of a page, in pure ASCII, so that it survives any transport.

    With `frames` it may show other pages of this folder.
    """
    style, digest = _style()
    policy = (
        f"default-src 'none'; style-src 'sha256-{digest}'; img-src data:; "
        "base-uri 'none'; form-action 'none'"
    ) + ("; frame-src 'self' file:" if frames else "")
    head = el(
        "head",
        el("meta", charset="utf-8"),
        el("meta", **{"http-equiv": "Content-Security-Policy"}, content=policy),
        el("meta", name="viewport", content="width=device-width, initial-scale=1"),
        el("meta", name="color-scheme", content="light dark"),
        el("meta", name="referrer", content="no-referrer"),
        el("meta", name="generator", content=GENERATED_BY),
        el("link", rel="icon", href="data:,"),
        el("title", one_line(title)),
    )
    sheet = Element("style")
    sheet.text = style  # verbatim: it is our own, and its hash is in the policy
    head.append(sheet)
    page = el("html", head, el("body", el("div", *body, class_="page")), lang="en")
    html = ET.tostring(page, "us-ascii", method="html").decode("ascii")
    return f"<!DOCTYPE html>\n{html}\n"


@functools.cache
def _style() -> tuple[str, str]:
    """Return the style sheet and its hash for the policy."""
    style = "\n".join(path.read_text("utf-8").replace("\r\n", "\n") for path in (TOKENS, STYLE))
    return style, base64.b64encode(hashlib.sha256(style.encode()).digest()).decode()


def _bodies(rows: Iterable[Element]) -> list[Element]:
    """Return rows wrapped in a table body; bodies are returned as they are."""
    rows = list(rows)
    return rows if rows and rows[0].tag == "tbody" else [el("tbody", rows)]


def _set_roles(grid: Element, headings: list[str]) -> None:
    roles = {"thead": "rowgroup", "tbody": "rowgroup", "tr": "row", "td": "cell"}
    grid.set("role", "table")
    for element in grid.iter():
        if element.tag in roles:
            element.set("role", roles[element.tag])
        if element.tag == "th":
            column = element.get("scope") == "col"
            element.set("role", "columnheader" if column else "rowheader")
    for row in grid.iter("tr"):
        for cell, heading in zip(row, headings, strict=False):
            if cell.tag == "td":
                cell.set("data-label", heading)


def _add_text(parent: Element, text: str) -> None:
    if len(parent):
        parent[-1].tail = (parent[-1].tail or "") + text
    else:
        parent.text = (parent.text or "") + text
