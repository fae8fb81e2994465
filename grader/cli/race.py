"""`course race`: how a node drives in three worlds, beside the reference; the table of a class."""

from __future__ import annotations

import contextlib
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from grader.cli.given import as_files, one_of
from grader.cli.results import FULL, LESS, check_writable, write_report
from grader.cli.start import portable_option, start_forkserver
from grader.errors import InputError
from grader.report.echo import echo

if TYPE_CHECKING:
    from grader.drive.standings import Result

EXAMPLES = """\b
Examples:
  course race 3 seeker.py --report race.html
  course race 1 my_agent.py --nickname "Ada L." --out race.json
  course race --table results --csv race.csv
"""


@click.command(epilog=EXAMPLES)
@click.argument("given", metavar="[N] [FILE]", nargs=-1)
@click.option("--nickname", help="Write the result for the table of the class, by this name.")
@click.option(
    "--out", type=click.Path(path_type=Path),
    help="Where it is written, if it is your best there; default race_EXERCISE.json.",
)  # fmt: skip
@click.option("--report", type=click.Path(path_type=Path), help="Write HTML replays with ghosts.")
@click.option("--table", metavar="FOLDER", type=click.Path(path_type=Path), help="Of all results.")
@click.option("--csv", type=click.Path(path_type=Path), help="Write the table as a CSV file, too.")
@portable_option
def race(
    given: tuple[str, ...],
    nickname: str | None,
    out: Path | None,
    report: Path | None,
    table: Path | None,
    csv: Path | None,
    portable: bool,
) -> int:
    """Race a node in three worlds, beside the reference's figures; nobody judges it.

    What counts is the time to a goal, or the way driven in a world's time; who touches something
    or breaks a limit of the exercise has none. Nothing is written unless a nickname is given.
    """
    if table is not None:
        if given or nickname or out or report:
            raise InputError("--table: expected a folder of results, and nothing to race")
        return _class_table(table, csv)
    if csv is not None or not 1 <= len(given) <= 2:
        raise InputError("expected the file of a node, or --table FOLDER, perhaps with --csv FILE")
    if out is not None and nickname is None:
        raise InputError("--out: expected a --nickname, too: by that name the class will see it")
    from grader import drive as driving  # noqa: PLC0415
    from grader.course.exercises import exercise_for  # noqa: PLC0415
    from grader.course.submission import find_submission  # noqa: PLC0415
    from grader.drive import race as racing  # noqa: PLC0415
    from grader.drive.standings import lap_rows, lines, wanted_at  # noqa: PLC0415
    from grader.exercises import contract_of  # noqa: PLC0415

    exercise = exercise_for(one_of(given[:-1], None), Path(given[-1]).name)
    worlds, contract = racing.worlds_of(exercise), contract_of(exercise)
    target = out or Path(f"race_{exercise.slug}.json")
    name, before = wanted_at(target, exercise, nickname)
    check_writable(report)
    check_writable(target if name else None)
    file = click.get_current_context().with_resource(as_files(Path(given[-1]), exercise.files))
    submission = find_submission(file, exercise.files[0])
    with start_forkserver(exercise.libraries, portable=portable) as forkserver:
        scenarios = map(driving.scenario_for, worlds)
        recordings = [driving.drive_node(submission, each, forkserver) for each in scenarios]
    laps = tuple(racing.lap_of(recording, contract) for recording in recordings)
    ghosts = racing.reference_laps(exercise.slug)
    best = {"your best": before.laps} if before else {}
    reference = [ghosts[world][0] for world in worlds]
    echo(lines(lap_rows(exercise, {"yours": laps, **best, "reference": reference})))
    for recording, lap in zip(recordings, laps, strict=True):
        said = [f"not finished: {lap.ended}" if lap.ended else racing.too_near(lap, contract)]
        if not lap.ended:
            track = ghosts[lap.world][1]
            said.append(racing.loss_to("the reference", track, recording, contract))
        for text in filter(None, said):
            echo(f"{lap.world}: {text}")
    echo(racing.rules_of(exercise))
    if report is not None:
        tracks = {world: [("reference", ghosts[world][1])] for world in worlds}
        write_report(report, None, recordings, f"Race of {Path(given[-1]).name}", ghosts=tracks)
    if name:
        _keep(target, (exercise.slug, name, laps), before, submission.path.read_bytes())
    return FULL if all(lap.figure is not None for lap in laps) else LESS


def _keep(target: Path, made: tuple[Any, ...], before: Result | None, code: bytes) -> None:
    """Write a result, unless the one that is there is as good; keep its code for oneself."""
    import msgspec  # noqa: PLC0415

    from grader.drive.standings import Result  # noqa: PLC0415
    from grader.grading.attempts import history, replace  # noqa: PLC0415
    from grader.grading.grading import versions  # noqa: PLC0415

    result = Result(versions().get("rclpy-agents-course", "unknown"), *made)
    if not result.finished:
        echo("No result is written: no world was finished")
        return
    if before is not None and before.rank <= result.rank:
        echo(f"{target} has your best, and stays as it is")
        return
    target.write_bytes(msgspec.json.format(msgspec.json.encode(result), indent=1) + b"\n")
    echo(f"Result, by the nickname {result.nickname}: {target}")
    with contextlib.suppress(OSError):  # nothing hangs on it
        place = history().with_name(f"race_{result.exercise}_{target.stem}.py")
        replace(place, code)
        echo(f"Its code, for you to go back to: {place}")


def _class_table(folder: Path, csv: Path | None) -> int:
    from grader.course.exercises import find_exercise  # noqa: PLC0415
    from grader.drive.race import ranking_of, rules_of  # noqa: PLC0415
    from grader.drive.standings import class_rows, lines, standings  # noqa: PLC0415
    from grader.lms.tables import csv_text  # noqa: PLC0415

    check_writable(csv)
    found, said = standings(folder)
    tables = {slug: class_rows(find_exercise(slug), results) for slug, results in found.items()}
    for slug, rows in tables.items():
        exercise = find_exercise(slug)
        echo(f"{exercise.title}\n{lines(rows, left=2)}\n{rules_of(exercise)}")
    for text in said or ([] if found else ["no results"]):
        echo(text)
    if found:
        echo("Figures are as the files claim them: `course race` with a student's node tells.")
    if csv is not None:
        for slug, rows in tables.items():
            rows[0][0] = ranking_of(find_exercise(slug))
        written = [[slug, *row] for slug, rows in tables.items() for row in rows]
        csv.write_text(csv_text(written), "utf-8-sig")  # as spreadsheets know it
        echo(f"Table: {csv}")
    return FULL if found else LESS
