"""`course doctor`: can nodes run on this machine, and may other people's code?"""

from __future__ import annotations

import dataclasses

import click


@click.command()
def doctor() -> int:
    """Say what this machine offers, and what a class would fail on: a skeleton is graded to see.

    Exit code 0: nodes run here, and other people's code may be graded. 1: only your own. 2: no node
    runs here.
    """
    from grader.report.terminal import Console  # noqa: PLC0415
    from rclpy_virtual_time import PracticeServer  # noqa: PLC0415

    reason = PracticeServer.why_needed()
    if reason:
        from grader.report.diagnosis import render_practice  # noqa: PLC0415

        render_practice(reason, Console())
        return 1
    from grader.grading.trying import imports_that_fail, why_none_runs  # noqa: PLC0415
    from grader.report.diagnosis import render_diagnosis  # noqa: PLC0415
    from rclpy_virtual_time import Diagnosis  # noqa: PLC0415

    found = Diagnosis.of_this_machine()
    if not found.problem:
        found = dataclasses.replace(found, problem=why_none_runs())
    if not found.problem:
        trouble = (*found.trouble, *imports_that_fail())
        found = dataclasses.replace(found, trouble=trouble)
    render_diagnosis(found, Console())
    if found.problem:
        return 2
    return 1 if found.foreign_code else 0
