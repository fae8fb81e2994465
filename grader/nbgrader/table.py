"""The judge's verdict as the output of a test cell: HTML for the feedback, and plain text."""

import html
from collections.abc import Sequence
from dataclasses import dataclass

from nbformat import NotebookNode, v4

from grader.nbgrader.marks import Mark
from grader.report.facts import OUTCOMES, facts_of, in_order, plain, points_of, with_details

COLOURS = {"pass": "#1a7f37", "fail": "#b42318", "error": "#8250df"}
GREY = "#57606a"
CAUSE = "border-left:4px solid #b42318;padding:3px 12px"
CELL = "padding:3px 12px 3px 0;text-align:left;vertical-align:top;border:0"


@dataclass(frozen=True)
class Row:
    """A check, in words."""

    outcome: str
    word: str  # with its sign
    title: str
    points: str
    details: tuple[str, ...]


def output_of(mark: Mark, max_points: float, remarks: Sequence[str] = ()) -> NotebookNode:
    """Return the output for a test cell. Students' text is escaped."""
    said = [plain(text) for text in (mark.said, *remarks) if text]
    if mark.by_hand:
        said.append("A person has to look at this one before it counts.")
    won = "-" if mark.points is None else f"{mark.points:g}"
    head = f"{won} / {max_points:g} points"
    rows = _rows(mark)
    cause = [(name.capitalize(), plain(text)) for name, text in mark.cause]
    data = {
        "text/html": _html(head, rows, said, cause),
        "text/plain": _text(head, rows, [*said, *(f"{name}: {text}" for name, text in cause)]),
    }
    return v4.new_output("display_data", data)


def _rows(mark: Mark) -> list[Row]:
    rows = []
    for check, more in with_details(in_order(mark.checks)):
        outcome = check["outcome"] if check["outcome"] in OUTCOMES else "error"
        sign, _, word, _ = OUTCOMES[outcome]
        facts = [f"{name}: {text}" for name, text in facts_of(check)]
        details = [check.get("message") or "", *facts] if more else []
        clean = tuple(plain(text) for text in details if text)
        title = plain(check["title"])
        rows.append(Row(outcome, f"{sign} {word}", title, points_of(check), clean))
    return rows


def _html(
    head: str, rows: Sequence[Row], said: Sequence[str], cause: Sequence[tuple[str, str]]
) -> str:
    lines = [f"<p><strong>{html.escape(head)}</strong></p>"]
    lines += [f"<p>{html.escape(text)}</p>" for text in said]
    if cause:
        told = (f"<strong>{name}</strong> {html.escape(text)}" for name, text in cause)
        lines.append(f'<p style="{CAUSE}">{"<br>".join(told)}</p>')
    if rows:
        table = '<table style="border:0;margin:0 0 1em">'
        lines += [table, *(_html_row(row) for row in rows), "</table>"]
    return "\n".join(lines)


def _html_row(row: Row) -> str:
    colour = COLOURS.get(row.outcome, GREY)
    details = "".join(
        f'<div style="color:{GREY};white-space:pre-wrap">{html.escape(text)}</div>'
        for text in row.details
    )
    return (
        f'<tr><td style="{CELL};color:{colour};white-space:nowrap">{html.escape(row.word)}</td>'
        f'<td style="{CELL}">{html.escape(row.title)}{details}</td>'
        f'<td style="{CELL};white-space:nowrap">{html.escape(row.points)}</td></tr>'
    )


def _text(head: str, rows: Sequence[Row], said: Sequence[str]) -> str:
    lines = [head, *said]
    for row in rows:
        lines.append(f"{row.word:9} {row.title}  {row.points}".rstrip())
        lines += [f"{'':9} {text}" for text in row.details]
    return "\n".join(lines)
