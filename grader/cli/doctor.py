"""`course doctor`: can nodes run on this machine, and may other people's code?"""

from __future__ import annotations

import dataclasses

import click

DIED = "the node died"  # a skeleton doesn't, unless ROS can't start here


@click.command()
def doctor() -> int:
    """Say what this machine offers, and what a class would fail on: a skeleton is graded to see.

    Exit code 0: nodes run here, and other people's code may be graded. 1: only your own. 2: no node
    runs here.
    """
    from rich.console import Console  # noqa: PLC0415

    from grader.link.choice import why_not_linux  # noqa: PLC0415

    reason = why_not_linux()
    if reason:
        from grader.report.terminal import render_practice  # noqa: PLC0415

        render_practice(reason, Console())
        return 1
    from grader.link.doctor import diagnose  # noqa: PLC0415
    from grader.report.terminal import render_diagnosis  # noqa: PLC0415

    found = diagnose()
    if not found.problem:
        found = dataclasses.replace(found, problem=_try_it())
    render_diagnosis(found, Console())
    if found.problem:
        return 2
    return 1 if found.foreign_code else 0


def _try_it() -> str:
    """Grade a skeleton; return why that fails, "" if it does not."""
    from grader.course.exercises import all_exercises  # noqa: PLC0415
    from grader.errors import GraderError  # noqa: PLC0415
    from grader.grading.handed_in import grade_files  # noqa: PLC0415

    exercise = all_exercises()[0]
    files = {name: (exercise.folder / name).read_bytes() for name in exercise.files}
    try:
        grading = grade_files(exercise, files, trust=True)
    except GraderError as error:
        return str(error)
    failed = [
        check
        for check in grading["checks"]
        if check["outcome"] == "error" or DIED in (check["message"] or "")
    ]
    return f"{failed[0]['title']} {failed[0]['message']}" if failed else ""
