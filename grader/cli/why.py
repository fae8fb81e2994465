"""`course why`: one check of the last grading, with all its details."""

from __future__ import annotations

import click

from grader.errors import InputError


@click.command()
@click.argument("check", required=False)
def why(check: str | None) -> None:
    """Print all that the last grading found about CHECK, or about what failed first."""
    from grader.grading.attempts import last_grading  # noqa: PLC0415
    from grader.report.facts import first_failure, in_order  # noqa: PLC0415
    from grader.report.terminal import Console, render_check  # noqa: PLC0415
    from sim.toml_input import nearest  # noqa: PLC0415

    grading = last_grading()
    if grading is None:
        raise InputError("nothing has been graded here yet: course grade EXERCISE FILE")
    by_id = {each["id"]: each for each in in_order(grading["checks"])}
    if check is not None and check not in by_id:
        raise InputError(f"unknown check {check!r}{nearest(check, by_id)}")
    found = first_failure(grading) if check is None else by_id[check]
    if found is None:
        raise InputError("no check failed in the last grading; course why CHECK prints one")
    render_check(grading, found, Console())
