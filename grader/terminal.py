"""Show a grading in the terminal: a table, what went wrong, the score."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from rich.console import Console
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

if TYPE_CHECKING:
    from grader.doctor import Diagnosis

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
MAX_WIDTH = 110  # longer lines are hard to read
MAX_TEXT = 1200  # [characters] of one message; the page has all of it

_ESCAPES = re.compile(
    r"\x1b\][^\x07\x1b]*(?:\x07|\x1b\\)?"  # OSC: window titles, links
    r"|[\x1b\x9b]\[?[0-?]*[ -/]*[@-~]"  # CSI and two-character sequences
)
# C0 and C1 but tab and newline; the bidi controls can make a line read backwards.
_CONTROLS = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f\u200e\u200f\u202a-\u202e\u2066-\u2069]")


def render_terminal(grading: Mapping[str, Any], console: Console) -> None:
    """Print the checks, a failure's expected, actual, when and next step, and the score."""
    checks: Sequence[Check] = grading.get("checks", [])
    width = min(console.width, MAX_WIDTH)
    console.print()
    console.print(_heading(grading, console), width=width)
    for kind in ("core", "field"):
        group = [check for check in checks if check.get("kind", "core") == kind]
        if group:
            console.print()
            console.print(_group_title(kind, group, console), width=width)
            console.print(Padding(_table(group, console), (0, 0, 0, 1)), width=width)
    console.print()
    console.print(_score_line(grading, console, width), width=width)
    if absent := _points_out_of_reach(checks):
        said = (
            f"        {_points(absent)} more points are about libraries that are not installed here"
        )
        console.print(Text(said, style="yellow"), width=width)
    console.print(_field_line(grading, checks, console), width=width)
    for note in grading.get("notes", ()):
        console.print(
            Padding(Text(printable(note, console), style="yellow"), (0, 0, 0, 8)), width=width
        )
    console.print()


def render_diagnosis(found: Diagnosis, console: Console) -> None:
    """Print what `course doctor` found."""
    width = min(console.width, MAX_WIDTH)
    facts = Table(box=None, show_header=False, padding=(0, 2, 0, 1))
    facts.add_row("Python", found.python)
    facts.add_row("ROS 2", found.ros or "not found")
    for what, missing in found.extras.items():
        facts.add_row(
            Text("not here" if missing else "here", style="yellow" if missing else "green"),
            f"{what}: {', '.join(missing)} missing" if missing else what,
        )
    console.print(facts, width=width)
    layers = Table(box=None, padding=(0, 2, 0, 1), header_style="bold")
    for heading in ("Layer", "", "What it is for"):
        layers.add_column(heading)
    for layer in found.layers:
        sign, ascii_sign, _, style = OUTCOMES["pass" if layer.here else "fail"]
        mark = Text(ascii_sign if _ascii(console) else sign, style=style)
        layers.add_row(layer.name, mark, layer.text)
    console.print()
    console.print(layers, width=width)
    console.print()
    if found.problem:
        said = Text(f" No node can run here: {printable(found.problem, console)}", style="bold red")
    elif found.foreign_code:
        said = Text(f" Your own code only: {found.foreign_code}", style="yellow")
    else:
        said = Text(" Other people's code may be graded here.", style="green")
    console.print(said, width=width)


def printable(text: Any, console: Console) -> str:
    """Student text without escape sequences, control characters or what can't be encoded."""
    clean = _CONTROLS.sub("", _ESCAPES.sub("", str(text).replace("\r\n", "\n"))).expandtabs(4)
    if len(clean) > MAX_TEXT:
        clean = clean[: MAX_TEXT - 2].rstrip() + " …"
    encoding = console.encoding or "utf-8"
    return clean.encode(encoding, "replace").decode(encoding)


def _heading(grading: Mapping[str, Any], console: Console) -> Text:
    heading = Text(" ")
    heading.append(printable(grading.get("exercise", ""), console), style="bold")
    for fact in (grading.get("file"), _tier(grading)):
        if fact:
            heading.append(_dot(console), style="dim")
            heading.append(printable(fact, console), style="dim")
    return heading


def _tier(grading: Mapping[str, Any]) -> str:
    return f"tier {grading['tier']}" if grading.get("tier") is not None else ""


def _group_title(kind: str, group: Sequence[Check], console: Console) -> Text:
    title = Text(" ")
    title.append("Core" if kind == "core" else "Field", style="bold")
    if kind == "core":
        points = _points(sum(check["points"] for check in group))
        judged = (check for check in group if check["outcome"] not in UNJUDGED)
        most = _points(sum(check["max_points"] for check in judged))
        fact = f"{points} of {most} points"
    else:
        fact = f"{_passed(group)} of {len(group)} passed, no points"
    title.append(_dot(console) + fact, style="dim")
    return title


def _table(checks: Iterable[Check], console: Console) -> Table:
    table = Table.grid(padding=(0, 2, 0, 0), expand=True)
    table.add_column(width=8, no_wrap=True)
    table.add_column(ratio=1)
    table.add_column(width=7, justify="right", no_wrap=True)
    reason = ""  # of the last skipped check: said once
    for check in checks:
        sign, ascii_sign, word, style = OUTCOMES.get(check["outcome"], OUTCOMES["error"])
        outcome = Text(f"{ascii_sign if _ascii(console) else sign} {word}", style=style)
        table.add_row(outcome, _title(check, console), _points_of(check))
        skipped = check["outcome"] in SKIPPED
        skipped_again = skipped and check.get("message") == reason
        if check["outcome"] != "pass" and not skipped_again:
            _add_details(table, check, console)
        reason = check.get("message", "") if skipped else ""
    return table


def _title(check: Check, console: Console) -> Text:
    style = "bold" if check["outcome"] in ("fail", "error") else ""
    return Text(printable(check["title"], console), style=style)


def _points_of(check: Check) -> Text:
    if check.get("kind") == "field" or not check.get("max_points"):
        return Text("")
    if check["outcome"] in UNJUDGED:
        return Text("-", style="dim")
    return Text(f"{_points(check['points'])}/{_points(check['max_points'])}", style="dim")


def _add_details(table: Table, check: Check, console: Console) -> None:
    if check.get("message"):
        table.add_row("", Text(printable(check["message"], console)), "")
    facts = Table.grid(padding=(0, 2, 0, 0))
    facts.add_column(width=8, no_wrap=True, style="dim")
    facts.add_column()
    for name, text in _facts(check):
        facts.add_row(name, Text(printable(text, console)))
    if facts.row_count:
        table.add_row("", facts, "")
    if check["outcome"] not in SKIPPED:
        table.add_row("", "", "")


def _facts(check: Check) -> list[tuple[str, str]]:
    facts = [("expected", check.get("expected")), ("actual", check.get("actual"))]
    time, scenario = check.get("time"), check.get("scenario")
    if time is not None:
        facts.append(("when", f"{time:.2f} s" + (f" in {scenario}" if scenario else "")))
    elif scenario and check["outcome"] not in SKIPPED:
        facts.append(("run", str(scenario)))
    facts.append(("next", check.get("help")))
    return [(name, str(text)) for name, text in facts if text]


def _score_line(grading: Mapping[str, Any], console: Console, width: int) -> Text:
    score, most = grading.get("score") or 0, grading.get("max_score") or 0
    share = min(1.0, max(0.0, score / most)) if most else 0.0
    cells = min(40, max(10, width - 34))
    full = round(share * cells)
    done, rest = ("#", ".") if _ascii(console) else ("█", "░")
    line = Text(" Score  ")
    line.append(f"{_points(score)} / {_points(most)}", style="bold")
    line.append("  ")
    line.append(done * full, style="green" if share >= 1 else "cyan")
    line.append(rest * (cells - full), style="dim")
    if grading.get("provisional"):
        line.append("\n        provisional", style="bold magenta")
        line.append(": a check could not be judged, so a person has to look", style="dim")
    return line


def _points_out_of_reach(checks: Sequence[Check]) -> float:
    return sum(float(c["max_points"]) for c in checks if c["outcome"] == "unavailable")


def _field_line(grading: Mapping[str, Any], checks: Sequence[Check], console: Console) -> Text:
    field = [check for check in checks if check.get("kind") == "field"]
    line = Text(" Field  ")
    ready = grading.get("field_ready")
    if ready:
        line.append(("* " if _ascii(console) else "★ ") + "field-ready", style="bold green")
        line.append(": works on other sensors and networks too", style="dim")
    elif ready is None:
        line.append("field checks were not run", style="dim")
    else:
        line.append("not field-ready yet")
        line.append(f" ({_passed(field)} of {len(field)} field checks passed)", style="dim")
    return line


def _passed(checks: Sequence[Check]) -> int:
    return sum(check["outcome"] == "pass" for check in checks)


def _points(points: float) -> str:
    return f"{points:g}"


def _ascii(console: Console) -> bool:
    return not (console.encoding or "utf-8").lower().startswith("utf")


def _dot(console: Console) -> str:
    return "  -  " if _ascii(console) else "  ·  "
