"""Pages from templates, which need neither scripts nor the network."""

import base64
import functools
import hashlib
from pathlib import Path
from urllib.parse import quote

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

from grader.classroom.amendments import marks
from grader.classroom.results import words
from grader.lms.clean import one_line, visible
from grader.report.page import GENERATED_BY

TEMPLATES = Path(__file__).resolve().parent / "templates"
DESK = Path(__file__).resolve().parents[1] / "desk" / "templates"
TOKENS = Path(__file__).resolve().parents[2] / "report" / "player" / "tokens.css"


def render(template: str, title: str, *, desk: bool = False, **about: object) -> str:
    """Return the HTML of a page, in pure ASCII, so that it survives any transport.

    Text is escaped. A page of the `desk` may send forms to its server, and show its other pages.
    """
    style, digest = _style(desk=desk)
    policy = (
        f"default-src 'none'; style-src 'sha256-{digest}'; img-src data:; base-uri 'none'; "
        + ("form-action 'self'; frame-src 'self'" if desk else "form-action 'none'")
    )
    html = (
        _environment()
        .get_template(template)
        .render(title=title, policy=Markup(policy), style=Markup(style), **about)
    )
    return html.encode("ascii", "xmlcharrefreplace").decode("ascii") + "\n"


@functools.cache
def _environment() -> Environment:
    made = Environment(
        loader=FileSystemLoader([TEMPLATES, DESK]), autoescape=True, undefined=StrictUndefined,
        trim_blocks=True, lstrip_blocks=True, finalize=_seen,
    )  # fmt: skip
    made.globals |= {"generator": GENERATED_BY, "headings": words.headings}
    made.filters |= {
        "before_cap": lambda result: marks.raw_points(result)[2],
        "cap": marks.cap_of,
        "coordinate": lambda value: f"{value:.2f}".rstrip("0").rstrip("."),
        "moment": words.moment,
        "one_line": one_line,
        "passed": marks.passed,
        "plural": words.plural,
        "points": words.points,
        "points_of": marks.points_of,
        "so_far": marks.so_far,
        "state": marks.state_of,
        "url": quote,
    }
    made.tests |= {
        "absent": marks.is_absent,
        "graded": marks.is_graded,
        "held": marks.is_held,
        "provisional": marks.is_provisional,
    }
    return made


def _seen(value: object) -> object:
    """Return text without control and bidi characters, which a template then escapes."""
    return visible(value) if isinstance(value, str) and not isinstance(value, Markup) else value


@functools.cache
def _style(*, desk: bool) -> tuple[str, str]:
    files = (TOKENS, TEMPLATES / "class.css", *([DESK / "desk.css"] if desk else []))
    style = "\n".join(path.read_text("utf-8").replace("\r\n", "\n") for path in files)
    return style, base64.b64encode(hashlib.sha256(style.encode()).digest()).decode()
