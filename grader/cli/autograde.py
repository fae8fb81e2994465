"""`course autograde`: grade a class."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from grader.cli.results import FAULT, FULL, LESS
from grader.errors import InputError

EXAMPLES = """\b
Examples:
  course autograde handed_in --out graded --workers 4
  course autograde handed_in --out graded --exercise 1 --field --secret course.secret
  course autograde handed_in --out graded --regrade
"""


@click.command(epilog=EXAMPLES)
@click.argument("submissions", type=click.Path(path_type=Path))
@click.option("--out", required=True, type=click.Path(path_type=Path), help="Results and state.")
@click.option("--exercise", "exercises", multiple=True, metavar="EXERCISE", help="Only this one.")
@click.option(
    "--workers", type=click.IntRange(1, 256), default=1, help="Processes on this machine."
)
@click.option("--dask", default="", metavar="ADDRESS|FILE", help="Use a Dask cluster's workers.")
@click.option(
    "--secret",
    type=click.Path(path_type=Path),
    help="File with the course's secret: each student gets different worlds.",
)
@click.option("--field", is_flag=True, help="Run the field checks too (badge, no points).")
@click.option("--regrade", is_flag=True, help="Judge the stored recordings again; runs no nodes.")
@click.option("--retry-held", is_flag=True, help="Grade again what is held after an attempt.")
@click.option("--no-bags", is_flag=True, help="Keep no recordings: no replays, no --regrade.")
@click.option("--trust", is_flag=True, help="Run submissions even where isolation is too weak.")
@click.option("--canaries", type=click.IntRange(0, 10_000), default=25, metavar="N",
              help="Grade known solutions every N submissions; 0: never.")  # fmt: skip
@click.option("--hide", default="nothing", help="From students: nothing, field, worlds, details.")
def autograde(
    submissions: Path,
    out: Path,
    secret: Path | None,
    regrade: bool,
    no_bags: bool,
    **options: Any,  # fields of grader.classroom.options.Options, under their own names
) -> int:
    """Grade a class: SUBMISSIONS holds a folder or an archive per student.

    Safe to run again after anything: it continues, and grades only what is new or changed. Exit
    code 0: all graded. 1: some are held for a person. 2: wrong usage, or the grader's fault.
    """
    from rich.console import Console  # noqa: PLC0415

    from grader.link.choice import why_no_class  # noqa: PLC0415

    no_class = "" if regrade or options["dask"] else why_no_class(trust=options["trust"])
    if no_class:
        raise InputError(no_class)
    from grader.classroom.batch import autograde as grade_class  # noqa: PLC0415
    from grader.classroom.options import Options  # noqa: PLC0415
    from grader.classroom.progress import ConsoleProgress, say, summary  # noqa: PLC0415
    from grader.classroom.results import ResultOptions  # noqa: PLC0415
    from grader.course.students import read_secret  # noqa: PLC0415

    ResultOptions(hide=options["hide"])  # refuses unknown words before the work
    chosen = Options(
        secret=None if secret is None else read_secret(secret), bags=not no_bags, **options
    )
    console = Console()
    with ConsoleProgress(console) as progress:
        graded = grade_class(submissions, out, chosen, progress, regrade=regrade)
    lines, held = summary(graded, out)
    say(console, lines)
    if graded.missing:
        return FAULT
    return LESS if held else FULL
