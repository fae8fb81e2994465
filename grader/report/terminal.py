"""Show a grading in the terminal: the checks, what went wrong first, the score, what to do next.

What a student needs stands last, in the rows above the prompt: `ROWS` at most, whatever was said.
Notebooks, reports and nbgrader show the same words, in the same order (`in_order`).
"""

from __future__ import annotations

import io
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from rich.console import Console as _Console
from rich.console import ConsoleOptions, RenderableType
from rich.padding import Padding
from rich.segment import Segment
from rich.table import Table
from rich.text import Text

from grader.report import facts
from rclpy_virtual_time import readable

Fact = tuple[str, Text, int]  # name, text, the most rows that it may take

PROVISIONAL = "provisional"
PROVISIONAL_WHY = ": a check could not be judged, so a person has to look"
SINCE = "since the last attempt"
MAX_WIDTH = 110  # longer lines are hard to read
ROWS = 20  # of an 80-column terminal, from the cause to the prompt
SIGN = 11  # [characters] of a check's sign and word
SPARED = ("Log", "Change", "Field", "Seen")  # what gives way if there are more, in this order


class Console(_Console):
    """A terminal for text that others may have written: all of it becomes `readable`."""

    def __init__(self, **settings: Any) -> None:
        super().__init__(emoji=False, **settings)  # `:x:` in a node's words is no picture

    def render(
        self, renderable: RenderableType, options: ConsoleOptions | None = None
    ) -> Iterator[Segment]:
        """Yield the printed text; only Rich's own sequences move the cursor or set colours."""
        for segment in super().render(renderable, options):
            text, style, control = segment
            if control or (text.isascii() and text.isprintable()):
                yield segment
            else:
                yield Segment(_encodable(readable(text), self), style)


def render_terminal(
    grading: Mapping[str, Any],
    console: _Console,
    changed: str = "",
    *,
    everything: bool = False,
    todo: str = "",
) -> None:
    """Print the checks, then the first failure with its cause, the score and what to do next.

    `changed`: what changed since the last attempt; `everything`: the details of every check, not
    one line each; `todo`: what to type next.
    """
    checks = facts.in_order(grading.get("checks", []))
    width = min(console.width, MAX_WIDTH)
    first = facts.first_failure(grading)
    console.print()
    console.print(_heading(grading, console), width=width)
    if everything or first is None:
        _print_tables(checks, console, width)
    else:
        console.print()
        _print_lines([check for check in checks if check is not first], console, width)
    for note in _notes(grading):
        said = Text(printable(note, console), style="yellow")
        console.print(Padding(said, (0, 0, 0, 1)), width=width)
    console.print()
    found = _facts_of_failure(grading, first, console) if first is not None else []
    if everything:  # the table has the others
        found = [fact for fact in found if fact[0].lower() in dict(facts.cause_of(grading))]
    elif first is not None:
        _print_signed(_head(first, console), console, width)
    found += _facts_of_score(grading, console, width, changed, todo)
    for line in _last_rows(found, width):
        console.print(line, width=width)


def render_check(grading: Mapping[str, Any], check: facts.Check, console: _Console) -> None:
    """Print a check's full verdict, with the cause if this check shows it."""
    width = min(console.width, MAX_WIDTH)
    table = Padding(_table([check], console), (0, 0, 0, 1))
    console.print()
    console.print(_heading(grading, console), width=width)
    console.print()
    console.print(table, width=width)
    cause = grading.get("cause") or {}
    if check["id"] != cause.get("check") and check["id"] not in cause.get("explains", ()):
        return
    grid = Table.grid(padding=(0, 2, 0, 0))
    grid.add_column(no_wrap=True, style="bold")
    grid.add_column(overflow="fold")
    for name, text in facts.cause_of(grading):
        grid.add_row(name.capitalize(), Text(printable(text, console)))
    if said := (cause.get("hint") or {}).get("text"):
        grid.add_row("", Text(printable(said, console)))
    console.print(Padding(grid, (0, 0, 0, 1)), width=width)


def printed(grading: Mapping[str, Any], width: int) -> str:
    """Return what `render_terminal` prints on a terminal of this width, without colour."""
    text = io.StringIO()
    console = Console(file=text, width=width, color_system=None, force_terminal=False)
    render_terminal(grading, console, everything=True)
    lines = [line.rstrip() for line in text.getvalue().strip("\n").splitlines()]
    return "\n".join(lines).replace("\n\n\n", "\n\n") + "\n"


def is_ascii(console: _Console) -> bool:
    """Return whether the terminal shows nothing but ASCII."""
    return not (console.encoding or "utf-8").lower().startswith("utf")


def printable(text: Any, console: _Console) -> str:
    """Return student text without escape sequences, control and unencodable characters."""
    return _encodable(facts.plain(text), console)


def _encodable(text: str, console: _Console) -> str:
    encoding = console.encoding or "utf-8"
    return text.encode(encoding, "replace").decode(encoding)


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


def _print_tables(checks: Sequence[facts.Check], console: _Console, width: int) -> None:
    for kind in ("core", "field"):
        group = [check for check in checks if check.get("kind", "core") == kind]
        if group:
            console.print()
            console.print(_group_title(kind, group, console), width=width)
            console.print(Padding(_table(group, console), (0, 0, 0, 1)), width=width)


def _print_lines(checks: Sequence[facts.Check], console: _Console, width: int) -> None:
    """Print a line for each failure, and above them what passed and what was not judged."""
    passed = [check for check in checks if check["outcome"] == "pass"]
    skipped = Counter(
        str(check.get("message") or "not judged")
        for check in checks
        if check["outcome"] in facts.SKIPPED
    )
    if passed:
        names = ", ".join(str(check.get("id") or check["title"]) for check in passed)
        line = _signed("pass", f"{len(passed)} passed: {printable(names, console)}", console)
        _print_signed(line, console, width)
    for reason, count in skipped.items():
        line = _signed("skip", f"{count} {printable(reason, console)}", console)
        _print_signed(line, console, width)
    for check in checks:
        if check["outcome"] not in ("pass", *facts.SKIPPED):
            console.print(_line(check, console, width), width=width)


def _line(check: facts.Check, console: _Console, width: int) -> Text:
    """Return a check in one row: sign, task, name, title, points."""
    task = f"task {check['task']}, " if check.get("task") else ""
    said = f"{task}{check.get('id') or ''}: {check['title']}"
    line = _signed(check["outcome"], printable(" ".join(said.split()), console), console)
    points = facts.points_of(check)
    (first, *_) = _rows(line, width - len(points) - 3, 1)
    first.pad_right(max(0, width - 1 - len(points) - first.cell_len))
    return first.append(points, style="dim")


def _signed(outcome: str, text: str, console: _Console) -> Text:
    sign, ascii_sign, word, style = facts.OUTCOMES.get(outcome, facts.OUTCOMES["error"])
    line = Text(f" {ascii_sign if is_ascii(console) else sign} {word:6}  ", style=style)
    return line.append(text, style="not bold default")


def _print_signed(line: Text, console: _Console, width: int) -> None:
    """Print a sign and a text in at most two rows."""
    sign, said = line.divide([SIGN])
    rows = _rows(said, width - SIGN, 2)
    for head, row in zip((sign, *[Text(" " * SIGN)] * (len(rows) - 1)), rows, strict=True):
        console.print(head.copy().append_text(row), width=width)


def _rows(line: Text, width: int, most: int) -> list[Text]:
    """Return a text in rows, at most so many; the last ends with dots if there would be more."""
    rows = list(line.wrap(_Console(width=width), max(width, 8), overflow="fold"))
    for row in rows:
        row.rstrip()
    if len(rows) <= most:
        return rows
    last = rows[most - 1]
    last.truncate(max(width, 8) - 4)
    return [*rows[: most - 1], last.append(" ...")]


def _head(check: facts.Check, console: _Console) -> Text:
    task = f"task {check['task']}, " if check.get("task") else ""
    name = f"{task}{check.get('id') or ''}: "
    points = f"  {facts.points_of(check)}" if facts.points_of(check) else ""
    line = _signed(check["outcome"], "", console)
    line.append(printable(name, console), style="not bold dim")
    line.append(printable(" ".join(check["title"].split()), console), style="bold default")
    return line.append(points, style="not bold dim")


def _last_rows(found: Iterable[Fact], width: int) -> list[Text]:
    """Return the last rows above the prompt, `ROWS` at most."""
    rows = [(name, _fact(name, text, width, most)) for name, text, most in found]
    for spared in SPARED:
        if sum(len(lines) for _, lines in rows) > ROWS:
            rows = [row for row in rows if row[0] != spared]
    return [line for _, lines in rows for line in lines]


def _facts_of_score(
    grading: Mapping[str, Any], console: _Console, width: int, changed: str, todo: str
) -> list[Fact]:
    found = [("", Text(""), 1), ("Score", _score(grading, console, width), 1)]
    if grading.get("provisional"):
        said = Text(PROVISIONAL, style="bold magenta").append(PROVISIONAL_WHY, style="not bold dim")
        found.append(("", said, 2))
    if grading.get("cap"):
        found.append(("Cap", Text(printable(grading["cap"], console), style="yellow"), 2))
    if changed:
        said = Text(printable(changed, console), style="bold").append(f" ({SINCE})", "not bold dim")
        found.append(("Change", said, 1))
    if grading.get("field_ready") is not None or facts.first_failure(grading) is None:
        found.append(("Field", _field(grading, console), 1))
    if todo:
        found.append(("Next", Text(printable(todo, console)), 3))
    return found


def _facts_of_failure(
    grading: Mapping[str, Any], first: facts.Check, console: _Console
) -> list[Fact]:
    known = dict(facts.cause_of(grading))
    said = known.get("cause") or str(first.get("message") or "")
    dies = "cause" in known and bool(first.get("where"))  # the cause has the same words
    log = str(first.get("log") or "").splitlines()
    told = [
        ("Cause", said, 5),
        ("Line", known.get("line") or str(first.get("where") or "").split("\n")[0], 2),
        ("Seen", "" if dies else facts.seen_of(first), 2),
        ("Log", log[-1] if log else "", 2),
        ("Try", "" if "cause" in known else str(first.get("help") or ""), 3),
        ("Hint", known.get("hint") or ("" if known else facts.hint_of(first)), 2),
    ]
    return [
        (name, Text(printable(" ".join(text.split()), console)), most)
        for name, text, most in told
        if text
    ]


def _fact(name: str, text: Text, width: int, most: int) -> list[Text]:
    style = "bold" if name == "Cause" else ""
    indent = 8
    rows = _rows(text, width - indent, most)
    heads = [f" {name}".ljust(indent), *[" " * indent] * (len(rows) - 1)]
    for row in rows:
        row.stylize(style)
    told = zip(heads, rows, strict=True)
    return [Text.assemble((head, "bold"), row) for head, row in told]


def _notes(grading: Mapping[str, Any]) -> list[str]:
    """Return further notes; the cap stands beside the score."""
    asked = facts.points_by_question(grading)
    capped = str(grading.get("cap") or "")
    return [
        *([f"Asked: {asked}"] if asked else []),
        *(note for note in facts.score_notes(grading) if note != capped),
        *(str(note) for note in grading.get("notes", ())),
    ]


def _group_title(kind: str, group: Sequence[facts.Check], console: _Console) -> Text:
    title = Text(" ")
    title.append("Core" if kind == "core" else "Field", style="bold")
    title.append(_dot(console) + facts.group_fact(kind, group), style="dim")
    return title


def _table(checks: Iterable[facts.Check], console: _Console) -> Table:
    table = Table.grid(padding=(0, 2, 0, 0), expand=True)
    table.add_column(width=8, no_wrap=True)
    table.add_column(ratio=1, overflow="fold")  # Rich's ellipsis is no ASCII
    table.add_column(width=7, justify="right", no_wrap=True)
    for check, more in facts.with_details(checks):
        sign, ascii_sign, word, style = facts.OUTCOMES.get(
            check["outcome"], facts.OUTCOMES["error"]
        )
        outcome = Text(f"{ascii_sign if is_ascii(console) else sign} {word}", style=style)
        table.add_row(outcome, _title(check, console), Text(facts.points_of(check), style="dim"))
        if more:
            _add_details(table, check, console)
    return table


def _title(check: facts.Check, console: _Console) -> Text:
    style = "bold" if check["outcome"] in ("fail", "error") else ""
    title = Text(printable(check["title"], console), style=style)
    if check.get("id"):
        place = f"task {check['task']}, " if check.get("task") else ""
        title.append(f"  ({place}{printable(check['id'], console)})", style="not bold dim")
    return title


def _add_details(table: Table, check: facts.Check, console: _Console) -> None:
    if check.get("message"):
        table.add_row("", Text(printable(check["message"], console)), "")
    grid = Table.grid(padding=(0, 2, 0, 0))
    grid.add_column(width=8, no_wrap=True, style="dim")
    grid.add_column(overflow="fold")
    for name, text in facts.facts_of(check):
        grid.add_row(name, Text(printable(text, console)))
    if grid.row_count:
        table.add_row("", grid, "")
    if check["outcome"] not in facts.SKIPPED:
        table.add_row("", "", "")


def _score(grading: Mapping[str, Any], console: _Console, width: int) -> Text:
    share = facts.share_of(grading)
    cells = min(40, max(5, width - 34))
    full = round(share * cells)
    done, rest = ("#", ".") if is_ascii(console) else ("█", "░")
    line = Text(facts.score_of(grading), style="bold")
    line.append("  ")
    line.append(done * full, style="green" if share >= 1 else "cyan")
    line.append(rest * (cells - full), style="dim")
    return line


def _field(grading: Mapping[str, Any], console: _Console) -> Text:
    word, rest = facts.field_words(grading)
    line = Text("")
    if word:
        line.append(("* " if is_ascii(console) else "★ ") + word, style="bold green")
    return line.append(rest, style="dim")


def _dot(console: _Console) -> str:
    return "  -  " if is_ascii(console) else "  ·  "
