"""`course report`: what a graded class came to, and what people changed in it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from grader.cli.results import FULL, JSON_STDOUT
from grader.report.echo import write

if TYPE_CHECKING:
    from grader.classroom.amendments.log import Entry
    from grader.classroom.desk.marking import Marking

EXAMPLES = """\b
Examples:
  course report graded
  course report graded --student ann
  course report graded --json log.json
"""


@click.command(epilog=EXAMPLES)
@click.argument("folder", type=click.Path(path_type=Path))
@click.option("--student", default="", metavar="ID", help="Only what is about this one, in full.")
@click.option("--json", "json_", metavar="PATH|-", help="Write the log as JSON; -: to stdout.")
def report(folder: Path, student: str, json_: str | None) -> int:
    """Print the log of marks of a graded class: who changed what, when and why."""
    from grader.classroom.desk.marking import is_about, reading  # noqa: PLC0415
    from grader.classroom.progress import say  # noqa: PLC0415
    from grader.report.terminal import Console  # noqa: PLC0415

    with reading(folder) as class_:
        entries = class_.entries
        who = class_.student(student) if student else ""
        if who:
            entries = [entry for entry in entries if is_about(entry, who, class_.rows)]
        if json_:
            text = json.dumps([_plain(entry) for entry in entries], indent=2) + "\n"
            if json_ == JSON_STDOUT:
                write(text)
            else:
                Path(json_).write_text(text, "utf-8")
        else:
            lines = _about(class_, who) if who else [class_.summary()]
            say(Console(), "\n".join([*lines, *_log(class_, entries)]))
    return FULL


def _about(class_: Marking, student: str) -> list[str]:
    """Return how a student's points came about."""
    lines = [student]
    for result, graded, counts in class_.points(student):
        lines.append(f"  {result.exercise}: {counts}" + ("" if graded == counts else
                     f", graded {graded}"))  # fmt: skip
        if result.amended is not None:
            numbers = ", ".join(map(str, result.amended.entries))
            lines += [f"    {step}" for step in result.amended.steps]
            lines.append(f"    by entry {numbers} of the log")
    return lines


def _log(class_: Marking, entries: list[Entry]) -> list[str]:
    from grader.classroom.amendments.log import described, undone_by  # noqa: PLC0415
    from grader.classroom.results.words import moment  # noqa: PLC0415

    if not entries:
        return ["Nobody has changed a mark."]
    undone = dict(undone_by(class_.entries))
    lines = ["The log of marks:"]
    for entry in entries:
        after = f"  [undone by {undone[entry.number]}]" if entry.number in undone else ""
        lines.append(f"{entry.number:4}  {moment(entry.at)}  {entry.who}{after}")
        lines.append(f"      {described(entry.change)}")
        lines.append(f"      why: {entry.why}")
    return lines


def _plain(entry: Entry) -> dict[str, Any]:
    import msgspec  # noqa: PLC0415

    what = msgspec.to_builtins(entry.change)
    return {
        "number": entry.number, "at": entry.at, "who": entry.who, "what": what, "why": entry.why,
    }  # fmt: skip
