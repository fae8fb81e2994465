"""`course grade`: run one node and judge it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from grader.cli.given import as_files
from grader.cli.results import JSON_STDOUT, check_writable, show
from grader.cli.start import portable_option, start_forkserver
from grader.course.students import Seed
from grader.errors import InputError

if TYPE_CHECKING:
    from grader.grading.grading import Grading

EXAMPLES = """\b
Examples:
  course grade 1 my_agent.py
  course grade 3 my_folder --field --report report.html
  course grade 1 my_agent.py --only stop_zone --json -
"""


@click.command(epilog=EXAMPLES)
@click.argument("exercise")
@click.argument("file", metavar="FILE|FOLDER", type=click.Path(path_type=Path))
@click.option(
    "--tier", type=click.IntRange(1, 2), default=1, help="1: virtual time; 2: real time, on DDS."
)
@click.option("--field", is_flag=True, help="Run the field checks too (badge, no points).")
@click.option("--only", multiple=True, metavar="CHECK", help="Run this check and what it needs.")
@click.option("--seed", type=click.IntRange(0, 10**6), help="Vary worlds and noise, not sensors.")
@click.option("--student", metavar="ID", help="Use this student's own worlds; needs --secret.")
@click.option("--secret", type=click.Path(path_type=Path), help="File with the course's secret.")
@click.option("--json", "json_", metavar="PATH|-", help="Write the result as JSON; -: to stdout.")
@click.option("--report", type=click.Path(path_type=Path), help="Write an HTML report.")
@click.option("--bags", type=click.Path(path_type=Path), help="Save every trial as a bag here.")
@click.option("--all", "everything", is_flag=True, help="Print the details of every check.")
@portable_option
def grade(
    exercise: str,
    file: Path,
    tier: int,
    field: bool,
    only: tuple[str, ...],
    seed: int | None,
    student: str | None,
    secret: Path | None,
    json_: str | None,
    report: Path | None,
    bags: Path | None,
    everything: bool,
    portable: bool,
) -> int:
    """Grade a node: EXERCISE by name or number, FILE or a FOLDER that holds it, or a package.

    What lies beside it comes along. A FOLDER with package.xml runs as with ros2 run, or as its
    launch file says. A notebook is its %%node cells, and a zip what is in it. FILE may be a link;
    links in the FOLDER, or beside the FILE, are refused.

    Exit code 0: full core score. 1: less. 2: wrong usage, the grader's own fault, or a check
    that a person has to judge.
    """
    from grader.course.exercises import find_exercise  # noqa: PLC0415
    from grader.course.submission import file_beside, find_submission  # noqa: PLC0415

    chosen = find_exercise(exercise)
    if file.name in chosen.files[1:] and file_beside(file, chosen.files[0]) is not None:
        file = file.with_name(chosen.files[0])  # whichever is given, the first one is the node
    given = click.get_current_context().with_resource(as_files(file, chosen.files))
    if given.name in chosen.files[1:] and file_beside(given, chosen.files[0]) is not None:
        given = given.with_name(chosen.files[0])  # of a notebook, or of copies
    submission = find_submission(given, chosen.files[0], chosen.files[1:])
    vary: Seed | None = seed
    if student is not None or secret is not None:
        vary = _student_key(student, secret, chosen.slug, seed)
    check_writable(report, json_)
    if portable and tier == 2:
        raise InputError("--portable and --tier 2 exclude each other: there is no DDS")
    from grader.cli.waiting import Waiting  # noqa: PLC0415

    waiting = Waiting(f"Exercise {chosen.number}, {file.name}", quiet=json_ == JSON_STDOUT)
    with waiting, start_forkserver(chosen.libraries, portable=portable) as forkserver:
        from grader.grading.attempts import keep, since_last  # noqa: PLC0415
        from grader.grading.grading import grade_submission  # noqa: PLC0415
        from grader.grading.onward import shown  # noqa: PLC0415

        grading = grade_submission(
            chosen,
            submission,
            forkserver,
            file=str(file),
            field=field,
            only=only,
            seed=vary,
            bags=bags,
            tier=tier,
            on_progress=waiting,
        )
    changed = ""
    if vary is None and tier == 1:  # the same worlds
        changed = since_last(grading, file)
    keep(grading.as_dict())
    todo = _todo(grading, f"{chosen.number} {shown(file)}")
    return show(grading, json_, report, changed, everything=everything, todo=todo)


def _todo(grading: Grading, what: str) -> str:
    """Return what to type next."""
    from grader.report.facts import first_failure  # noqa: PLC0415

    first = first_failure(grading.as_dict())
    if first is not None:
        return f"course why CHECK says more; course grade {what} --only {first['id']}"
    whole = grading.score == grading.exercise.max_points
    return f"hand in {', '.join(grading.exercise.files)}; course next" if whole else "course next"


def _student_key(student: str | None, secret: Path | None, slug: str, seed: int | None) -> str:
    from grader.course.students import read_secret, student_key  # noqa: PLC0415

    if student is None or secret is None:
        raise InputError("--student and --secret go together")
    if seed is not None:
        raise InputError("--seed and --student exclude each other")
    return student_key(read_secret(secret), student, slug)
