"""`course start`, `course next`, `course progress`: begin an exercise, go on, go elsewhere."""

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
PROGRESS = """\b
Examples:
  course progress course-progress.json
  course progress course-progress.json --export
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


@click.command("progress", epilog=PROGRESS)
@click.argument("file", type=click.Path(path_type=Path))
@click.option(
    "--export", is_flag=True, help="Save into FILE; what it has stays among its versions."
)
def progress_(file: Path, export: bool) -> None:
    """Lay the work of a FILE that the page has saved into the exercises' folders here.

    What is yours there stays: beside it another file gets a name of its own. With --export FILE is
    saved from these folders, for the page or for another computer.
    """
    from grader.cli import progress  # noqa: PLC0415

    if export:
        before = progress.read_progress(file) if file.exists() else None
        found, said = progress.progress_of(Path(), before)
        progress.write_progress(found, file)
        if before is None:
            said.append(f"{file} is new: earlier versions are in the file that the page has saved.")
            said.append("Export into that to keep them.")
        said.append(f"{file}: work in {', '.join(found.exercises) or 'no exercise'}")
    else:
        found = progress.read_progress(file)
        said = progress.bring(found, Path()) or ["Everything in it is here already."]
        if any(work.versions for work in found.exercises.values()):
            said.append(f"Earlier versions stay in {file}: --export into it keeps them.")
    for line in said:
        echo(line)


def _course() -> str:
    """Return the command as this person has to type it: not everybody's PATH has it."""
    return "course" if shutil.which("course") else sys.argv[0]
