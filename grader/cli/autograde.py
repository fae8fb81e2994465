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
  course autograde handed_in --out graded --regrade ann
  course autograde week1.zip week2.zip --roster gradebook.csv --out graded
  course autograde late.zip --roster gradebook.csv --out graded --add
  course autograde submissions.zip --roster gradebook.csv --list
"""


EVERYBODY = "\0everybody"  # no student is called so


@click.command(epilog=EXAMPLES)
@click.argument("submissions", nargs=-1, type=click.Path(path_type=Path))
@click.option("--out", type=click.Path(path_type=Path), help="Results and state.")
@click.option("--exercise", "exercises", multiple=True, metavar="EXERCISE", help="Only this one.")
@click.option(
    "--roster",
    "rosters",
    multiple=True,
    type=click.Path(path_type=Path),
    help="Canvas's or Moodle's gradebook export, a grading worksheet, a CSV. May be repeated.",
)
@click.option(
    "--column", "columns", multiple=True, metavar="EXERCISE=TITLE", help="The gradebook's column."
)
@click.option("--list", "only_list", is_flag=True, help="Say who handed in what; grade nothing.")
@click.option("--add", is_flag=True, help="Keep who is graded and not in SUBMISSIONS.")
@click.option("--drop", is_flag=True, help="Forget who is graded and not in SUBMISSIONS.")
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
@click.option(
    "--regrade",
    is_flag=False,
    flag_value=EVERYBODY,
    multiple=True,
    metavar="[ID]",
    help="Judge the stored recordings again, of all or of one student; runs no nodes.",
)
@click.option("--again", multiple=True, metavar="ID", help="Run this student's nodes once more.")
@click.option("--retry-held", is_flag=True, help="Grade again what is held after an attempt.")
@click.option("--no-bags", is_flag=True, help="Keep no recordings: no replays, no --regrade.")
@click.option("--trust", is_flag=True, help="Run submissions even where isolation is too weak.")
@click.option("--canaries", type=click.IntRange(0, 10_000), default=25, metavar="N",
              help="Grade known solutions every N submissions; 0: never.")  # fmt: skip
@click.option("--hide", default="", help="From students: nothing, field, worlds, details.")
def autograde(
    submissions: tuple[Path, ...],
    out: Path | None,
    rosters: tuple[Path, ...],
    only_list: bool,
    secret: Path | None,
    regrade: tuple[str, ...],
    no_bags: bool,
    **options: Any,  # fields of grader.classroom.options.Options, under their own names
) -> int:
    """Grade a class.

    SUBMISSIONS are downloads of Canvas, Moodle or Gradescope, as folders or archives, nbgrader's
    exchange, GitHub Classroom's clones, or a folder with a folder or an archive per student.

    Safe to run again after anything: it continues, and grades only what is new or changed. Exit
    code 0: all graded. 1: some are held, or not understood: a person should look. 2: wrong usage,
    or the grader's fault.

    Give later runs into the same folder the same options.
    """
    from grader.launchers import why_no_class  # noqa: PLC0415
    from grader.report.terminal import Console  # noqa: PLC0415

    if not submissions:
        after = "; what comes after --regrade is a student" if regrade else ""
        raise InputError(f"expected SUBMISSIONS, what the class has handed in{after}")
    if out is None and not only_list:
        raise InputError("expected --out FOLDER, where the results go (or --list)")
    if options["add"] and options["drop"]:
        raise InputError("--add keeps results and --drop forgets them: expected one of them")
    if regrade and options["again"]:
        raise InputError("--regrade runs no nodes and --again does: expected one of them")
    no_class = "" if regrade or options["dask"] else why_no_class(trust=options["trust"])
    if no_class and not only_list:
        raise InputError(no_class)
    from grader.classroom.batch import autograde as grade_class  # noqa: PLC0415
    from grader.classroom.batch import looked_at  # noqa: PLC0415
    from grader.classroom.options import Options  # noqa: PLC0415
    from grader.classroom.progress import Progress, say  # noqa: PLC0415
    from grader.classroom.results.options import ResultOptions, column_titles  # noqa: PLC0415
    from grader.cli.batch import listing, summary  # noqa: PLC0415
    from grader.course.students import read_secret  # noqa: PLC0415
    from grader.lms.sheets import read_roster  # noqa: PLC0415

    ResultOptions(hide=options["hide"] or "nothing")  # refuses unknown words before the work
    column_titles(options["columns"])
    chosen = Options(
        secret=None if secret is None else read_secret(secret),
        bags=not no_bags,
        only=() if EVERYBODY in regrade else regrade,
        roster=read_roster(rosters),
        **options,
    )
    console = Console()
    if only_list or out is None:
        with looked_at(submissions, chosen, out) as found:
            text, waiting = listing(found)
        say(console, text)
        return LESS if waiting else FULL
    graded = grade_class(submissions, out, chosen, Progress(console), regrade=bool(regrade))
    lines, held = summary(graded, out)
    say(console, lines)
    if graded.missing:
        return FAULT
    return LESS if held else FULL
