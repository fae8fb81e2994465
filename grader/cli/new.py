"""`course new`: make a new exercise."""

from __future__ import annotations

import click

from grader.cli.results import FULL
from grader.report.echo import echo

EXAMPLES = """\b
Examples:
  course new give_way
"""


@click.command(epilog=EXAMPLES)
@click.argument("name")
def new(name: str) -> int:
    """Make a new exercise called NAME, in all the places of one: small, graded and proven.

    Make it yours from there, and ask `python -m grader.authoring.proof NAME` as you go.
    """
    from grader.authoring.scaffold import scaffold  # noqa: PLC0415

    made = scaffold(name)
    echo(f"Exercise {made.number}, {made.slug}. New:")
    for path in made.new:
        echo(f"  {path}")
    echo("It is also in these lists; say there in your words what it is about:")
    for path in made.edited:
        echo(f"  {path}")
    echo("See that it is right, and again after each change:")
    for command in (f".venv/bin/python -m grader.authoring.proof {name}", "make lint"):
        echo(f"  {command}")
    return FULL
