"""`course check-bag`: judge saved recordings."""

from __future__ import annotations

from pathlib import Path

import click

from grader.cli.results import check_writable, show
from grader.errors import InputError

EXAMPLES = """\b
Examples:
  course grade 3 my_seeker.py --bags bags
  course check-bag bags/goal_origin_to_5_3 3
  course check-bag bags 3
"""


@click.command("check-bag", epilog=EXAMPLES)
@click.argument("bag", type=click.Path(path_type=Path))
@click.argument("exercise")
@click.option("--only", multiple=True, metavar="CHECK", help="Run this check and what it needs.")
@click.option("--field", is_flag=True, help="Run the field checks too.")
@click.option("--json", "json_", metavar="PATH|-", help="Write the result as JSON; -: to stdout.")
@click.option("--report", type=click.Path(path_type=Path), help="Write an HTML report.")
def check_bag(
    bag: Path,
    exercise: str,
    only: tuple[str, ...],
    field: bool,
    json_: str | None,
    report: Path | None,
) -> int:
    """Judge saved recordings: BAG is one bag, or a folder of them. No student code runs."""
    from grader.course.exercises import find_exercise  # noqa: PLC0415
    from grader.grading.grading import grade  # noqa: PLC0415
    from grader.recording.bag import load_all  # noqa: PLC0415
    from grader.trial.trials import SavedTrials  # noqa: PLC0415

    chosen = find_exercise(exercise)
    check_writable(report, json_)
    trials = SavedTrials(load_all(bag))
    grading = grade(chosen, trials, file=str(bag), field=field, only=only)
    if {check["outcome"] for check in grading.as_dict()["checks"]} == {"skip"}:
        names = ", ".join(sorted(recording.name for recording in trials.recordings()))
        raise InputError(
            f"{bag}: recorded in {names}; no check of exercise {chosen.number} is about that alone"
        )
    return show(grading, json_, report)
