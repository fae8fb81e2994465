"""`course delay`: the largest delay of sensors and commands that a node survives."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from grader.cli.given import one_of
from grader.cli.results import FULL, LESS
from grader.cli.start import portable_option, start_forkserver
from grader.report.foreign import echo

EXAMPLES = """\b
Examples:
  course delay my_agent.py --exercise 1
"""


@click.command(epilog=EXAMPLES)
@click.argument("number", metavar="[N]", nargs=-1)
@click.argument("file", type=click.Path(path_type=Path))
@click.option("--exercise", metavar="N", help="Whose worlds; else the file's name tells.")
@portable_option
def delay(number: tuple[str, ...], file: Path, exercise: str | None, portable: bool) -> int:
    """Find out how late sensors and commands may be for a node.

    It drives in its exercise's closed-loop worlds with delays of 0 to 300 ms. This is no grading:
    it gives and takes no points.

    Exit code 0: the node survives at least without delay. 1: it does not. 2: wrong usage.
    """
    from rich.text import Text  # noqa: PLC0415

    from grader.course.exercises import exercise_for  # noqa: PLC0415
    from grader.course.submission import find_submission  # noqa: PLC0415
    from grader.drive import drive_in  # noqa: PLC0415
    from grader.drive.delay import delays  # noqa: PLC0415
    from grader.drive.delay_table import table  # noqa: PLC0415
    from grader.exercises import driving_contract_of  # noqa: PLC0415
    from grader.report.terminal import Console  # noqa: PLC0415

    chosen = exercise_for(one_of(number, exercise), file.name)
    contract = driving_contract_of(chosen)  # or refuse, before anything starts
    submission = find_submission(file, chosen.files[0])
    console = Console(file=sys.stderr, highlight=False)
    doing = f"Exercise {chosen.number}, {file.name}"
    with (
        console.status(Text(f"{doing}: getting ready"), spinner="line") as status,
        start_forkserver(chosen.libraries, portable=portable) as forkserver,
    ):
        result = delays(
            chosen,
            lambda scenario: drive_in(submission, scenario, forkserver),
            on_drive=lambda done, of: status.update(Text(f"{doing}: drive {done} of {of}")),
        )
    for line in table(result, contract.survives):
        echo(line)
    survived = result.survived
    return FULL if min(survived.sensors, survived.commands) >= 0 else LESS
