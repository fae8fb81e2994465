"""Where a command's result goes: the terminal, JSON, an HTML report, the exit code."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from grader.errors import InputError
from grader.report.echo import echo, write

if TYPE_CHECKING:
    from grader.grading.grading import Grading
    from grader.recording import Recording
    from grader.report.replay import Ghosts

FULL, LESS, FAULT = 0, 1, 2  # exit codes
JSON_STDOUT = "-"


def check_writable(report: Path | None, json_: str | None = None) -> None:
    """Refuse, before the work begins, a file that can't be written after it.

    Raises InputError: its folder does not exist, or it is a folder itself.
    Raises OSError: it can't be created.
    """
    for target in (report, Path(json_) if json_ and json_ != JSON_STDOUT else None):
        if target is not None and not target.resolve().parent.is_dir():
            raise InputError(f"{target}: its folder does not exist")
        if target is not None and target.is_dir():
            raise InputError(f"{target}: expected a file to write, but this is a folder")
        if target is not None and not target.exists():
            target.touch()  # an OSError says what is wrong
            target.unlink()


def show(
    grading: Grading,
    json_: str | None,
    report: Path | None,
    changed: str = "",
    *,
    everything: bool = False,
    todo: str = "",
) -> int:
    """Print a grading, write its JSON and its report, and return the exit code.

    `changed`: what changed since the last attempt; it is printed, and in no file; `everything`:
    each check with its details; `todo`: what to type next.
    """
    result = grading.as_dict()
    if json_ != JSON_STDOUT:
        from grader.report.terminal import Console, render_terminal  # noqa: PLC0415

        render_terminal(result, Console(), changed, everything=everything, todo=todo)
    if json_:
        from grader.report.page import json_text  # noqa: PLC0415

        text = json_text(result)
        if json_ == JSON_STDOUT:
            write(text)
        else:
            Path(json_).write_text(text, "utf-8")
    if report is not None:
        title = f"{grading.exercise.title}: {Path(grading.file).name}"
        write_report(report, result, list(grading.recordings), title, quiet=bool(json_))
    if grading.faulty:
        return FAULT
    return FULL if grading.full else LESS


def write_report(
    path: Path,
    grading: dict[str, Any] | None,
    recordings: list[Recording],
    title: str,
    *,
    opens_at: float | None = None,
    ghosts: Mapping[str, Ghosts] | None = None,
    quiet: bool = False,
) -> None:
    """Write an HTML report with a replay of each recording (see `page_payload`)."""
    from grader.report.page import page_html, page_payload  # noqa: PLC0415

    payload = page_payload(grading, recordings, title, opens_at, ghosts)
    path.write_text(page_html(payload), "utf-8")
    if not quiet:
        echo(f"Report with replays: {path}")
