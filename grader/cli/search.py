"""`course search`: the smallest world in which a node fails."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from grader.cli.given import one_of
from grader.cli.results import FULL, LESS, check_writable, write_report
from grader.cli.start import portable_option, start_forkserver
from grader.report.echo import echo

EXAMPLES = """\b
Examples:
  course search my_agent.py --exercise 1
  course search my_agent.py --exercise 1 --minutes 3 --out found.toml --report found.html
  course search my_agent.py --exercise 1 --seed 7 --tries 300
  course drive my_agent.py --scenario found.toml
"""


@click.command(epilog=EXAMPLES)
@click.argument("number", metavar="[N]", nargs=-1)
@click.argument("file", type=click.Path(path_type=Path))
@click.option("--exercise", metavar="N", help="Whose contract counts; else the file's name tells.")
@click.option("--minutes", type=click.FloatRange(0.01, 600), help="How long to look; default 1.")
@click.option(
    "--tries", type=click.IntRange(1, 1_000_000),
    help="How many worlds to try instead: then the same seed finds the same world.",
)  # fmt: skip
@click.option("--seed", type=click.IntRange(0, 10**6), default=0, help="Where to begin; default 0.")
@click.option("--field", is_flag=True, help="Other sensors and networks too, as for the badge.")
@click.option("--out", type=click.Path(path_type=Path), help="Write the world as a scenario file.")
@click.option("--report", type=click.Path(path_type=Path), help="Write an HTML replay.")
@portable_option
def search(
    number: tuple[str, ...],
    file: Path,
    exercise: str | None,
    minutes: float | None,
    tries: int | None,
    seed: int,
    field: bool,
    out: Path | None,
    report: Path | None,
    portable: bool,
) -> int:
    """Look for the smallest world in which a node fails.

    A node fails that touches something, dies, breaks a limit, or stands for ever though its way is
    free. Ctrl-C keeps the smallest world so far. This is no grading: it gives and takes no points.

    Exit code 0: nothing was found. 1: a world was found. 2: wrong usage.
    """
    from rich.text import Text  # noqa: PLC0415

    from grader.course.exercises import exercise_for  # noqa: PLC0415
    from grader.course.submission import find_submission  # noqa: PLC0415
    from grader.drive import drive_in  # noqa: PLC0415
    from grader.drive import search as searching  # noqa: PLC0415
    from grader.report.terminal import Console  # noqa: PLC0415

    chosen = exercise_for(one_of(number, exercise), file.name)
    arena = searching.arena_of(chosen, field=field)
    submission = find_submission(file, chosen.files[0])
    check_writable(report)
    check_writable(out)
    doing = f"Exercise {chosen.number}, {file.name}"
    console = Console(file=sys.stderr, highlight=False)
    with (
        console.status(Text(f"{doing}: getting ready"), spinner="line") as status,
        start_forkserver(chosen.libraries, portable=portable) as forkserver,
    ):
        result = searching.search(
            arena, lambda scenario: drive_in(submission, scenario, forkserver),
            seed=seed, tries=tries, minutes=minutes,
            on_try=lambda _, so_far: status.update(Text(f"{doing}: {so_far}")),
        )  # fmt: skip
    echo(result.account(exercise=chosen.number, seed=seed))
    if (found := result.found) is None:
        return FULL
    if out is not None:
        out.write_text(found.toml, "utf-8")
        echo(f"Scenario: {out}")
    if report is not None:
        title = f"{file.name}: {found.sentence}"
        write_report(report, None, [found.recording], title, opens_at=found.mishap.at)
    return LESS
