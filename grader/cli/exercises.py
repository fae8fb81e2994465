"""`course list`."""

from __future__ import annotations

from itertools import groupby
from operator import itemgetter
from pathlib import Path

import click

EXAMPLES = """\b
Examples:
  course list
  course list --scenarios
"""


@click.command("list", epilog=EXAMPLES)
@click.option(
    "--scenarios", is_flag=True, help="The scenarios, for `course drive --scenario NAME`."
)
def list_(*, scenarios: bool) -> None:
    """List the exercises, or the scenarios that come with the course."""
    from rich.table import Table  # noqa: PLC0415

    from grader.report.terminal import Console  # noqa: PLC0415

    table = Table(box=None, padding=(0, 2, 0, 0), header_style="bold")
    if scenarios:
        table.add_column("Scenario", no_wrap=True)
        table.add_column("What happens in it")
        for row in _scenarios():
            table.add_row(*row)
    else:
        table.add_column("#")
        table.add_column("Exercise", no_wrap=True)
        table.add_column("File", no_wrap=True)
        table.add_column("What it is about")
        for row in _exercises():
            table.add_row(*row)
    Console().print(table)


def _exercises() -> list[tuple[str, ...]]:
    from grader.course.exercises import all_exercises  # noqa: PLC0415

    return [
        (str(exercise.number), exercise.slug, "\n".join(exercise.files), exercise.summary)
        for exercise in all_exercises()
    ]


def _scenarios() -> list[tuple[str, ...]]:
    """Return names and titles, under the folder's name: an exercise's, or `demo`."""
    from sim.scenario_files import load_scenario, scenario_names  # noqa: PLC0415

    rows: list[tuple[str, ...]] = []
    found = sorted((_folder_of(path), name) for name, path in scenario_names().items())
    for folder, inside in groupby(found, key=itemgetter(0)):
        rows += [("", ""), (f"[bold]{folder}[/bold]", "")]
        rows += [(name, load_scenario(name).title) for _, name in inside]
    return rows


def _folder_of(path: Path) -> str:
    """Return the name of the exercise that has a scenario's file, or of the robot's own folder."""
    folder = path.parent
    return folder.parent.name if folder.name == "scenarios" else folder.name
