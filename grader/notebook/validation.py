"""Raise for failed checks under `nbgrader validate`, which passes every cell that doesn't raise.

A notebook can tell by an environment variable that this command, or the button Validate, runs it.
"""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from grader.notebook.report import CheckReport

VARIABLE = "NBGRADER_EXECUTION"
ACCEPTED = ("pass", "unavailable")  # a library that is not installed is nobody's mistake


class NotPassed(Exception):
    """Not every check of a test cell passed; raised only under `nbgrader validate`."""

    def _render_traceback_(self) -> list[str]:
        """Return the lines that IPython shows in place of a traceback."""
        return str(self).split("\n")


def validated(report: CheckReport | None) -> CheckReport | None:
    """Return the report; under `nbgrader validate`, raise unless all checks passed.

    Raises NotPassed: a check did not pass or could not be judged, under `nbgrader validate`.
    """
    if os.environ.get(VARIABLE) != "validate":
        return report
    if report is None:
        raise NotPassed("nothing could be judged; the cell says why")
    bad = [check for check in report.checks if check["outcome"] not in ACCEPTED]
    if bad:
        said = [f"{check['id']}: {check['message']}" for check in bad]
        raise NotPassed("\n".join([f"{len(bad)} checks did not pass", *said]))
    return report
