"""`course list`."""

from __future__ import annotations

import click

EXAMPLES = """\b
Examples:
  course list
"""


@click.command("list", epilog=EXAMPLES)
def list_() -> None:
    """List the exercises."""
    from rich.console import Console  # noqa: PLC0415
    from rich.table import Table  # noqa: PLC0415

    from grader.course.exercises import all_exercises  # noqa: PLC0415

    table = Table(box=None, padding=(0, 2, 0, 0), header_style="bold")
    for heading in ("#", "Exercise", "File", "What it is about"):
        table.add_column(heading)
    for exercise in all_exercises():
        files = ", ".join(exercise.files)
        table.add_row(str(exercise.number), exercise.slug, files, exercise.summary)
    Console().print(table)
