"""The log of changed marks, a table of the class's store: who changed what, when and why."""

from collections.abc import Sequence
from dataclasses import dataclass

from grader.classroom.amendments import change as changes


@dataclass(frozen=True)
class Entry:
    number: int
    at: str  # UTC, ISO 8601
    who: str
    change: changes.Change
    why: str


def active(entries: Sequence[Entry]) -> list[Entry]:
    """Return the entries that count, which are not undone."""
    undone = dict(undone_by(entries))
    return [
        each
        for each in entries
        if each.number not in undone and not isinstance(each.change, changes.Undo)
    ]


def undone_by(entries: Sequence[Entry]) -> list[tuple[int, int]]:
    """Return the entries that don't count, each with the one that undid it."""
    found: dict[int, int] = {}
    for entry in reversed(entries):
        if entry.number not in found and isinstance(entry.change, changes.Undo):
            found[entry.change.number] = entry.number
    return sorted(found.items())


def described(change: changes.Change) -> str:
    match change:
        case changes.SetCheck():
            words = f"{change.exercise}: {change.check} has {change.points:g} points"
        case changes.Waive():
            words = f"{change.exercise}: {change.check} does not count"
        case changes.Late():
            words = _late(change)
        case changes.Score():
            words = f"{change.exercise}: {change.points:g} points"
        case changes.Publish():
            words = f"feedback published: {', '.join(change.exercises) or 'all exercises'}"
        case changes.Assign():
            words = f"{change.was or ', '.join(change.entries)} is theirs"
        case changes.Accept():
            words = f"{change.exercise}: {change.file} counts as its file"
        case changes.Comment():
            words = f"{change.exercise}: on {change.file}, line {change.line}: {change.words}"
        case changes.Style():
            words = f"{change.exercise}: {style_words(change)}"
        case changes.Request():
            about = f", {change.check}" if change.check else ""
            words = f"{change.exercise}{about}: asks to look again: {change.words}"
        case changes.Answer():
            words = f"{change.exercise}: answer to request {change.request}: {change.words}"
        case changes.Undo() | changes.Unread():
            return str(change)
    return f"{words} ({change.whom})"


def style_words(style: changes.Style) -> str:
    single = "; ".join(f"{name} {won:g} of {most:g}" for name, (won, most) in style.given.items())
    won, most = style.sums
    return f"style {won:g} of {most:g} ({single})"


def _late(rule: changes.Late) -> str:
    when = f"after {rule.deadline}" if rule.deadline else "what the platform calls late"
    words = f"{rule.exercise}: {when}, {rule.per_day:g} % of the points a day"
    words += f", {duration(rule.grace)} of grace" if rule.grace else ""
    words += f", at most {rule.cap:g} %" if rule.cap < 100 else ""
    return words + (f", times of a file for {len(rule.times)}" if rule.times else "")


def duration(seconds: float) -> str:
    """Return a time span in the largest unit that fits."""
    for size, unit in ((86400, "d"), (3600, "h"), (60, "min")):
        if seconds >= size and not seconds % size:
            return f"{seconds / size:g} {unit}"
    return f"{seconds:g} s"
