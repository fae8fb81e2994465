"""`course start` and `course next`: begin an exercise, and go on."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

import click

from grader.report.echo import echo

STARTS = """\b
Examples:
  course start
  course start 3
"""
NEXTS = """\b
Examples:
  course next
  course next 3
"""


@click.command(epilog=STARTS)
@click.argument("exercise", required=False)
def start(exercise: str | None) -> None:
    """Make your folder of an EXERCISE here: task, hints, skeleton, tests of your own.

    Without a name or number it is the first exercise that has no folder here yet.
    """
    from grader.course.begin import begin, to_begin  # noqa: PLC0415
    from grader.course.exercises import find_exercise  # noqa: PLC0415

    here = Path()
    chosen = to_begin(here) if exercise is None else find_exercise(exercise)
    folder = begin(chosen, here)
    echo(
        f"Exercise {chosen.number}, {chosen.title.lower()}: {folder / 'README.md'} says what to "
        f"do, and you write {' and '.join(chosen.files)}.\n"
        f"Next, now and after each change:\n  {_course()} grade {chosen.number} {folder}"
    )


@click.command("next", epilog=NEXTS)
@click.argument("exercise", required=False)
def next_(exercise: str | None) -> None:
    """Say what to do next, in the EXERCISE that was graded last, or in this one."""
    from grader.course.exercises import find_exercise  # noqa: PLC0415
    from grader.grading.onward import onward  # noqa: PLC0415

    for line in onward(None if exercise is None else find_exercise(exercise)):
        echo(line.replace("  course", f"  {_course()}", 1) if line[0] == " " else line)


def _course() -> str:
    """Return the command as this person has to type it: not everybody's PATH has it."""
    return "course" if shutil.which("course") else sys.argv[0]
