"""`course desk`: a page to mark in."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import click

from grader.cli.results import FULL
from grader.errors import InputError
from grader.report.echo import echo

NO_LIBRARY = "the desk needs a library: pip install tornado (or the course with the extra desk)"
EXAMPLES = """\b
Examples:
  course desk graded
  course desk graded --for ann --for ben --port 8787
  ssh -L 8787:127.0.0.1:8787 HOST    from elsewhere, to a desk with --port 8787
"""


@click.command(epilog=EXAMPLES)
@click.argument("folder", type=click.Path(path_type=Path))
@click.option("--for", "names", multiple=True, metavar="NAME",
              help="Who gets an address; you, if nobody is named. May be repeated.")  # fmt: skip
@click.option("--port", type=click.IntRange(0, 65535), default=0, help="0: any that is free.")
def desk(folder: Path, names: tuple[str, ...], port: int) -> int:
    """Open a page to mark in, of the class that `course autograde` has graded into FOLDER.

    It is served on this machine only, until Ctrl-C, to those who have an address that is printed:
    each is one person's, whose name stands in the log. All that is changed there goes through the
    same log as with `course marks`.
    """
    if importlib.util.find_spec("tornado") is None:
        raise InputError(NO_LIBRARY)
    from grader.classroom.desk.marking import reading  # noqa: PLC0415
    from grader.classroom.desk.server import serve  # noqa: PLC0415
    from grader.cli.marks import user  # noqa: PLC0415

    with reading(folder) as class_:
        echo(class_.summary())

    def say(addresses: dict[str, str]) -> None:
        for name, address in addresses.items():
            echo(f"{name}: {address}")
        echo("Ctrl-C ends it.")

    try:
        serve(folder, names or (user(),), port, say)
    except KeyboardInterrupt:
        echo("The desk is closed.")
    return FULL
