"""Agree with `nbgrader validate`, which takes a test cell for passed unless something raises.

That command, and the button Validate, tell a notebook that they run it by their environment.
"""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from grader.notebook.report import CheckReport

VARIABLE = "NBGRADER_EXECUTION"
JUDGED = ("pass", "unavailable")  # a library that is not here is nobody's mistake


class NotPassed(Exception):
    """Not every check of a test cell passed; raised only where nbgrader validates."""

    def _render_traceback_(self) -> list[str]:
        """Return the lines that IPython shows in place of a traceback."""
        return str(self).split("\n")


def validated(report: CheckReport | None) -> CheckReport | None:
    """Return the report; where nbgrader validates, raise unless all checks passed.

    Raises
    ------
    NotPassed
        nbgrader validates, and a check did not pass or could not be judged.
    """
    if os.environ.get(VARIABLE) != "validate":
        return report
    if report is None:
        raise NotPassed("nothing could be judged: see what the cell says")
    bad = [check for check in report.checks if check["outcome"] not in JUDGED]
    if bad:
        said = [f"{check['id']}: {check['message']}" for check in bad]
        raise NotPassed("\n".join([f"{len(bad)} checks did not pass", *said]))
    return report
