"""What `check` shows: the terminal's table, in the same words, with replays below."""

import html
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from grader.notebook.frame import folded, frame_html
from grader.notebook.show import Bundle, execution_count, show
from grader.report import facts
from grader.report.terminal import PROVISIONAL, PROVISIONAL_WHY, SINCE

Check = Mapping[str, Any]

# Signs and words carry the meaning. White on these colours has a contrast of 4.5 or more.
COLOURS = {
    "pass": "#00735a",
    "fail": "#b83f00",
    "skip": "#5f6b77",
    "error": "#98386f",
    "inconclusive": "#7d5a00",
    "unavailable": "#5f6b77",
}
LINE = "1px solid rgba(128,128,128,.3)"
STYLE = f"""\
<style>
.course-check {{ max-width: 860px; font-size: 14px; line-height: 1.45; margin: 4px 0 10px; }}
.course-check p {{ margin: 2px 0; }}
.course-check .quiet {{ opacity: .72; }}
.course-check p.group {{ margin: 14px 0 4px; font-size: 15px; font-weight: 600; }}
.course-check p.group span {{ font-weight: normal; opacity: .72; }}
.course-check table.checks, .course-check table.checks * {{
  background: none; text-align: left; vertical-align: top; font-size: 14px; }}
.course-check table.checks {{ width: 100%; border-collapse: collapse; border: 0; margin: 0;
  table-layout: auto; color: inherit; }}
.course-check table.checks tr {{ border: 0; border-top: {LINE}; background: none; }}
.course-check table.checks td {{ padding: 6px 12px 6px 0; border: 0; max-width: none;
  white-space: normal; overflow-wrap: anywhere; color: inherit; }}
.course-check table.checks td.outcome {{ width: 86px; white-space: nowrap; }}
.course-check table.checks td.points {{ width: 56px; padding-right: 0; text-align: right;
  white-space: nowrap; font-variant-numeric: tabular-nums; }}
.course-check table.checks span.chip {{ display: inline-block; min-width: 62px; padding: 0 8px;
  border-radius: 9px; color: #fff; font-size: 12px; font-weight: 600; line-height: 19px; }}
.course-check .facts {{ display: grid; grid-template-columns: max-content 1fr; gap: 1px 12px;
  margin: 4px 0 2px; }}
.course-check .facts span:nth-child(odd) {{ opacity: .72; }}
.course-check .facts span {{ white-space: pre-wrap; overflow-wrap: anywhere; }}
.course-check code.quiet {{ font-size: 12px; background: none; color: inherit; }}
.course-check .message {{ white-space: pre-wrap; }}
.course-check .cause {{ margin: 8px 0; padding: 6px 12px; border-left: 4px solid #b83f00; }}
.course-check .score {{ display: flex; align-items: center; gap: 14px; margin-top: 14px;
  padding-top: 10px; border-top: 2px solid rgba(128,128,128,.45); }}
.course-check .label {{ display: inline-block; min-width: 48px; opacity: .72; }}
.course-check .bar {{ flex: 1; max-width: 320px; height: 10px; border-radius: 5px; overflow: hidden;
  background: rgba(128,128,128,.28); }}
.course-check .bar i {{ display: block; height: 10px; }}
</style>"""


@dataclass(eq=False, repr=False)
class CheckReport:
    """A verdict on one exercise, for the student who asked; it is not a mark.

    Attributes
    ----------
    grading
        The JSON object of `course grade --json`.
    """

    grading: dict[str, Any]
    _text: str  # the terminal's table
    _page: str  # replays; "" if there are none
    _first: str = ""  # title of the first replay
    _changed: str = ""  # since the last attempt
    _written: str = ""  # when the file was written
    _newer: str = ""  # a warning that the file is older than its cell
    _shown_in: int | None = field(default=None, init=False)  # the cell that showed it last

    @property
    def score(self) -> int:
        """Points won."""
        return int(self.grading["score"])

    @property
    def max_score(self) -> int:
        """Points that could be won: checks that could not judge are left out."""
        return int(self.grading["max_score"])

    @property
    def checks(self) -> list[dict[str, Any]]:
        """The checks' results: `id`, `title`, `outcome`, `points`, `max_points`, `message`, …"""
        return list(self.grading["checks"])

    def __repr__(self) -> str:
        """Return the terminal's table, and above it how old the file is."""
        about = (self._newer, f"{self._written}." if self._written else "")
        return "\n".join([*filter(None, about), self._text.strip("\n")])

    def _repr_html_(self) -> str:
        table = grading_html(self.grading, self._changed)
        return self._about() + table + replays_html(self.grading, self._page, self._first)

    def _about(self) -> str:
        newer = f'<p role="alert"><b>{_escaped(self._newer)}</b></p>' if self._newer else ""
        return newer + (f"<p>{_escaped(self._written)}.</p>" if self._written else "")

    def shown(self) -> Bundle:
        """Return what is shown below the running cell, and remember that cell."""
        self._shown_in = execution_count()
        return {"text/plain": repr(self), "text/html": self._repr_html_()}

    def _ipython_display_(self) -> None:
        """Show the report once a cell: `check` shows it, and may also be the cell's last line."""
        cell = execution_count()
        if cell is None or cell != self._shown_in:
            show(self.shown())


def grading_html(grading: Mapping[str, Any], changed: str = "") -> str:
    """Return a grading as HTML that follows the page's theme; students' text is escaped.

    `changed`: what changed since the last attempt.
    """
    checks = facts.in_order(grading.get("checks", []))
    groups = [
        _group(kind, group)
        for kind in ("core", "field")
        if (group := [check for check in checks if check.get("kind", "core") == kind])
    ]
    found = [grading.get("file"), f"tier {grading['tier']}" if grading.get("tier") else ""]
    heading = f"<b>{_escaped(grading.get('exercise', ''))}</b>" + "".join(
        f'<span class="quiet">  ·  {_escaped(fact)}</span>' for fact in found if fact
    )
    inside = f"<p>{heading}</p>{_cause(grading)}{''.join(groups)}{_score(grading, changed)}"
    return f'{STYLE}<div class="course-check">{inside}</div>'


def _cause(grading: Mapping[str, Any]) -> str:
    """Return the most probable cause, with its hint unfolded; nothing if none is known."""
    told = dict(facts.cause_of(grading))
    if not told:
        return ""
    lines = [f'<p class="message"><b>Cause</b> {_escaped(told["cause"])}</p>']
    if "line" in told:
        lines.append(f'<p class="message">{_escaped(told["line"])}</p>')
    if "hint" in told:
        text = (grading["cause"].get("hint") or {}).get("text", "")
        lines.append(
            f"<details open><summary>Hint: {_escaped(told['hint'])}</summary>"
            f'<p class="message">{_escaped(text)}</p></details>'
        )
    return f'<div class="cause">{"".join(lines)}</div>'


def replays_html(grading: Mapping[str, Any], page: str, first: str) -> str:
    """Return the replays below a grading: unfolded if something failed."""
    if not page:
        return ""
    failed = any(check["outcome"] == "fail" for check in grading["checks"])
    said = f"Replay of what failed: {first}" if failed else "Watch the runs"
    return folded(facts.plain(said), frame_html(page, title=facts.plain(said)), unfolded=failed)


def _group(kind: str, group: Sequence[Check]) -> str:
    title = "Core" if kind == "core" else "Field"
    rows = "".join(_row(check, more) for check, more in facts.with_details(group))
    return (
        f'<p class="group">{title}<span>  ·  {_escaped(facts.group_fact(kind, group))}</span></p>'
        f'<table class="checks" aria-label="{title} checks"><tbody>{rows}</tbody></table>'
    )


def _row(check: Check, more: bool) -> str:
    outcome = check["outcome"] if check["outcome"] in facts.OUTCOMES else "error"
    sign, _, word, _ = facts.OUTCOMES[outcome]
    strong = outcome in ("fail", "error")
    title = _escaped(check["title"])
    name = f' <code class="quiet">({_escaped(check["id"])})</code>' if check.get("id") else ""
    return (
        f'<tr><td class="outcome"><span class="chip" style="background:{COLOURS[outcome]}">'
        f"{sign} {word}</span></td>"
        f"<td>{f'<b>{title}</b>' if strong else title}{name}"
        f"{_details(check) if more else ''}</td>"
        f'<td class="points">{facts.points_of(check)}</td></tr>'
    )


def _details(check: Check) -> str:
    message = check.get("message")
    said = f'<p class="message">{_escaped(message)}</p>' if message else ""
    found = "".join(
        f"<span>{name}</span><span>{_escaped(text)}</span>" for name, text in facts.facts_of(check)
    )
    return said + (f'<div class="facts">{found}</div>' if found else "")


def _score(grading: Mapping[str, Any], changed: str) -> str:
    share = facts.share_of(grading)
    colour = COLOURS["pass"] if share >= 1 else "#2b7fba"
    word, rest = facts.field_words(grading)
    lines = [_escaped(note) for note in facts.score_notes(grading)]
    if grading.get("provisional"):
        lines.insert(0, f"<b>{PROVISIONAL}</b>{PROVISIONAL_WHY}")
    if asked := facts.points_by_question(grading):
        lines.append(f'<span class="label">Asked</span> {_escaped(asked)}')
    if changed:
        lines.append(f'<span class="label">Change</span> <b>{_escaped(changed)}</b> ({SINCE})')
    badge = f"<b>★ {word}</b>" if word else ""
    lines.append(f'<span class="label">Field</span> {badge}{_escaped(rest)}')
    lines += [_escaped(note) for note in grading.get("notes", ())]
    return (
        '<div class="score"><span><span class="label">Score</span> '
        f"<b>{facts.score_of(grading)}</b></span>"
        f'<div class="bar"><i style="width:{100 * share:.0f}%;background:{colour}"></i></div></div>'
        + "".join(f"<p>{line}</p>" for line in lines)
    )


def _escaped(text: Any) -> str:
    return html.escape(facts.plain(text))
