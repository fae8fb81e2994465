"""Show a grading in the terminal: a table, what went wrong, the score.

Notebooks and nbgrader show the same words.
"""

from __future__ import annotations

import io
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from rich.console import Console as _Console
from rich.console import ConsoleOptions, RenderableType
from rich.padding import Padding
from rich.segment import Segment
from rich.table import Table
from rich.text import Text

from grader.report.foreign import readable

Check = Mapping[str, Any]

OUTCOMES = {  # outcome: sign, sign on an ASCII terminal, word, style
    "pass": ("✓", "+", "pass", "green"),
    "fail": ("✗", "x", "FAIL", "bold red"),
    "skip": ("\N{EN DASH}", "-", "skip", "dim"),
    "error": ("!", "!", "ERROR", "bold magenta"),
    "inconclusive": ("?", "?", "unsure", "yellow"),
    "unavailable": ("\N{EN DASH}", "-", "skip", "yellow"),  # a library is not installed
}
SKIPPED = ("skip", "unavailable")
UNJUDGED = ("error", "inconclusive", "unavailable")  # neither won nor lost
PROVISIONAL = "provisional"
PROVISIONAL_WHY = ": a check could not be judged, so a person has to look"
SINCE = "since the last attempt"
MAX_WIDTH = 110  # longer lines are hard to read
MAX_TEXT = 1200  # [characters] of one message; the page has all of it


class Console(_Console):
    """A terminal for text that others may have written: all of it becomes `readable`."""

    def render(
        self, renderable: RenderableType, options: ConsoleOptions | None = None
    ) -> Iterator[Segment]:
        """Yield what is printed; only Rich's own sequences move the cursor or set colours."""
        for segment in super().render(renderable, options):
            text, style, control = segment
            if control or (text.isascii() and text.isprintable()):
                yield segment
            else:
                yield Segment(_encodable(readable(text), self), style)


def render_terminal(grading: Mapping[str, Any], console: _Console, changed: str = "") -> None:
    """Print the checks, of failed ones expected, actual, time and next step, and the score.

    `changed`: what changed since the last attempt.
    """
    checks: Sequence[Check] = grading.get("checks", [])
    width = min(console.width, MAX_WIDTH)
    console.print()
    console.print(_heading(grading, console), width=width)
    if told := cause_of(grading):
        console.print()
        console.print(_cause(told, console), width=width)
    for kind in ("core", "field"):
        group = [check for check in checks if check.get("kind", "core") == kind]
        if group:
            console.print()
            console.print(_group_title(kind, group, console), width=width)
            console.print(Padding(_table(group, console), (0, 0, 0, 1)), width=width)
    console.print()
    console.print(_score_line(grading, console, width), width=width)
    if asked := points_by_question(grading):
        console.print(Text(f" Asked  {asked}", style="dim"), width=width)
    if changed:
        console.print(_change_line(changed, console), width=width)
    for note in score_notes(grading):
        said = Text(printable(note, console), style="yellow")
        console.print(Padding(said, (0, 0, 0, 8)), width=width)
    console.print(_field_line(grading, console), width=width)
    for note in grading.get("notes", ()):
        console.print(
            Padding(Text(printable(note, console), style="yellow"), (0, 0, 0, 8)), width=width
        )
    console.print()


def printed(grading: Mapping[str, Any], width: int) -> str:
    """Return what `render_terminal` prints on a terminal of this width, without colour."""
    text = io.StringIO()
    console = Console(file=text, width=width, color_system=None, force_terminal=False)
    render_terminal(grading, console)
    lines = [line.rstrip() for line in text.getvalue().strip("\n").splitlines()]
    return "\n".join(lines).replace("\n\n\n", "\n\n") + "\n"


def is_ascii(console: _Console) -> bool:
    """Return whether the terminal shows nothing but ASCII."""
    return not (console.encoding or "utf-8").lower().startswith("utf")


def printable(text: Any, console: _Console) -> str:
    """Return student text without escape sequences, control and unencodable characters."""
    return _encodable(plain(text), console)


def _encodable(text: str, console: _Console) -> str:
    encoding = console.encoding or "utf-8"
    return text.encode(encoding, "replace").decode(encoding)


def plain(text: Any) -> str:
    """Return student text without escape sequences and control characters, cut to MAX_TEXT."""
    clean = readable(str(text)).expandtabs(4)
    return clean if len(clean) <= MAX_TEXT else clean[: MAX_TEXT - 2].rstrip() + " …"


# --- words that notebooks and nbgrader use too ---------------------------------------------------


def cause_of(grading: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return the most probable cause of what failed, as lines (name, text); [] if none is known."""
    cause = grading.get("cause") or {}
    hint = cause.get("hint") or {}
    lines = [
        ("cause", cause.get("text", "")),
        ("line", cause.get("where", "")),
        ("hint", f"{hint.get('title', '')} ({hint.get('anchor', '')})" if hint else ""),
    ]
    return [(name, str(text)) for name, text in lines if text]


def group_fact(kind: str, group: Sequence[Check]) -> str:
    """Say how a group of checks, `core` or `field`, came out."""
    if kind != "core":
        return f"{_passed(group)} of {len(group)} passed, no points"
    judged = (check for check in group if check["outcome"] not in UNJUDGED)
    most = sum(check["max_points"] for check in judged)
    return f"{spell_points(sum(check['points'] for check in group))} of {spell_points(most)} points"


def points_of(check: Check) -> str:
    """Say how many points a check gave; "-" if it was not judged."""
    if check.get("kind") == "field" or not check.get("max_points"):
        return ""
    if check["outcome"] in UNJUDGED:
        return "-"
    return f"{spell_points(check['points'])}/{spell_points(check['max_points'])}"


def facts_of(check: Check) -> list[tuple[str, str]]:
    """Return the facts (name, text) about a check that did not pass."""
    facts = [("expected", check.get("expected")), ("actual", check.get("actual"))]
    time, scenario = check.get("time"), check.get("scenario")
    if time is not None:
        facts.append(("when", f"{time:.2f} s" + (f" in {scenario}" if scenario else "")))
    elif scenario and check["outcome"] not in SKIPPED:
        facts.append(("run", str(scenario)))
    facts += [("code", check.get("where")), ("log", check.get("log"))]
    facts.append(("next", check.get("help")))
    return [(name, str(text)) for name, text in facts if text]


def with_details(checks: Iterable[Check]) -> Iterator[tuple[Check, bool]]:
    """Yield checks, each with whether to show details: a reason for skipping is shown once."""
    reason = ""  # of the last skipped check
    for check in checks:
        skipped = check["outcome"] in SKIPPED
        yield check, check["outcome"] != "pass" and not (skipped and check.get("message") == reason)
        reason = check.get("message", "") if skipped else ""


def share_of(grading: Mapping[str, Any]) -> float:
    """Return the share of the points that was won, 0 … 1."""
    score, most = grading.get("score") or 0, grading.get("max_score") or 0
    return float(min(1.0, max(0.0, score / most))) if most else 0.0


def score_of(grading: Mapping[str, Any]) -> str:
    """Return the score, with the points that could be won."""
    score, most = (grading.get(key) or 0 for key in ("score", "max_score"))
    return f"{spell_points(score)} / {spell_points(most)}"


def score_notes(grading: Mapping[str, Any]) -> list[str]:
    """Return what else a reader of the score should know."""
    checks = grading.get("checks", [])
    absent = sum(float(c["max_points"]) for c in checks if c["outcome"] == "unavailable")
    said = f"{spell_points(absent)} more points are about libraries that are not installed here"
    capped = str(grading.get("cap") or "")
    return [*([capped] if capped else []), *([said] if absent else [])]


def points_by_question(grading: Mapping[str, Any]) -> str:
    """Return the points by what the checks ask: `wiring 5/5, decision 40/45`."""
    found: dict[str, list[float]] = {}
    for check in grading.get("checks", []):
        if check.get("asks") and check.get("kind") == "core" and check["outcome"] not in UNJUDGED:
            sums = found.setdefault(check["asks"], [0.0, 0.0])
            sums[0] += check["points"]
            sums[1] += check["max_points"]
    return ", ".join(f"{asks} {won:g}/{most:g}" for asks, (won, most) in found.items())


def field_words(grading: Mapping[str, Any]) -> tuple[str, str]:
    """Return what to say about the field checks: the badge's word, and the rest of the line."""
    field = [check for check in grading.get("checks", []) if check.get("kind") == "field"]
    if grading.get("field_ready"):
        return "field-ready", ": works on other sensors and networks too"
    if grading.get("field_ready") is None:
        return "", "field checks were not run"
    return "", f"not field-ready yet ({_passed(field)} of {len(field)} field checks passed)"


def spell_points(points: float) -> str:
    """Return points without superfluous decimals."""
    return f"{points:g}"


# --- the terminal --------------------------------------------------------------------------------


def _heading(grading: Mapping[str, Any], console: _Console) -> Text:
    heading = Text(" ")
    heading.append(printable(grading.get("exercise", ""), console), style="bold")
    for fact in (grading.get("file"), _tier(grading)):
        if fact:
            heading.append(_dot(console), style="dim")
            heading.append(printable(fact, console), style="dim")
    return heading


def _tier(grading: Mapping[str, Any]) -> str:
    return f"tier {grading['tier']}" if grading.get("tier") is not None else ""


def _cause(told: Iterable[tuple[str, str]], console: _Console) -> Padding:
    facts = Table.grid(padding=(0, 2, 0, 0))
    facts.add_column(no_wrap=True, style="bold")
    facts.add_column(overflow="fold")
    for name, text in told:
        style = "bold" if name == "cause" else ""
        facts.add_row(name.capitalize(), Text(printable(text, console), style=style))
    return Padding(facts, (0, 0, 0, 1))


def _group_title(kind: str, group: Sequence[Check], console: _Console) -> Text:
    title = Text(" ")
    title.append("Core" if kind == "core" else "Field", style="bold")
    title.append(_dot(console) + group_fact(kind, group), style="dim")
    return title


def _table(checks: Iterable[Check], console: _Console) -> Table:
    table = Table.grid(padding=(0, 2, 0, 0), expand=True)
    table.add_column(width=8, no_wrap=True)
    table.add_column(ratio=1, overflow="fold")  # Rich's ellipsis is no ASCII
    table.add_column(width=7, justify="right", no_wrap=True)
    for check, more in with_details(checks):
        sign, ascii_sign, word, style = OUTCOMES.get(check["outcome"], OUTCOMES["error"])
        outcome = Text(f"{ascii_sign if is_ascii(console) else sign} {word}", style=style)
        table.add_row(outcome, _title(check, console), Text(points_of(check), style="dim"))
        if more:
            _add_details(table, check, console)
    return table


def _title(check: Check, console: _Console) -> Text:
    style = "bold" if check["outcome"] in ("fail", "error") else ""
    title = Text(printable(check["title"], console), style=style)
    if check.get("id"):
        place = f"task {check['task']}, " if check.get("task") else ""
        title.append(f"  ({place}{printable(check['id'], console)})", style="not bold dim")
    return title


def _add_details(table: Table, check: Check, console: _Console) -> None:
    if check.get("message"):
        table.add_row("", Text(printable(check["message"], console)), "")
    facts = Table.grid(padding=(0, 2, 0, 0))
    facts.add_column(width=8, no_wrap=True, style="dim")
    facts.add_column(overflow="fold")
    for name, text in facts_of(check):
        facts.add_row(name, Text(printable(text, console)))
    if facts.row_count:
        table.add_row("", facts, "")
    if check["outcome"] not in SKIPPED:
        table.add_row("", "", "")


def _score_line(grading: Mapping[str, Any], console: _Console, width: int) -> Text:
    share = share_of(grading)
    cells = min(40, max(10, width - 34))
    full = round(share * cells)
    done, rest = ("#", ".") if is_ascii(console) else ("█", "░")
    line = Text(" Score  ")
    line.append(score_of(grading), style="bold")
    line.append("  ")
    line.append(done * full, style="green" if share >= 1 else "cyan")
    line.append(rest * (cells - full), style="dim")
    if grading.get("provisional"):
        line.append(f"\n        {PROVISIONAL}", style="bold magenta")
        line.append(PROVISIONAL_WHY, style="dim")
    return line


def _change_line(changed: str, console: _Console) -> Padding:
    line = Text("Change ")
    line.append(printable(changed, console), style="bold")
    line.append(f" ({SINCE})", style="dim")
    return Padding(line, (0, 0, 0, 1))


def _field_line(grading: Mapping[str, Any], console: _Console) -> Text:
    word, rest = field_words(grading)
    line = Text(" Field  ")
    if word:
        line.append(("* " if is_ascii(console) else "★ ") + word, style="bold green")
    line.append(rest, style="dim")
    return line


def _passed(checks: Sequence[Check]) -> int:
    return sum(check["outcome"] == "pass" for check in checks)


def _dot(console: _Console) -> str:
    return "  -  " if is_ascii(console) else "  ·  "
