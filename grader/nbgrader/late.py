"""Late penalties as nbgrader assigns them: so many per cent of the points for each day begun.

nbgrader's own plugin takes nothing or everything. The due date is the assignment's in the gradebook
(`nbgrader db assignment add NAME --duedate=2027-01-15T18:00:00+01:00`, or formgrader); the time of
a submission is the one that `nbgrader submit` wrote down.
"""

import functools
import math
from datetime import UTC, datetime
from typing import Any

from nbgrader.plugins import LateSubmissionPlugin
from traitlets import Float

DAY = 24 * 60 * 60  # [s]
ODD = (
    "%s is due at %s UTC (%s here), says the gradebook. Nobody sets such seconds: nbgrader takes "
    "an offset behind a blank, as in “18:00 +0100”, for seconds. If another time was meant: "
    "nbgrader db assignment add %s --duedate=2027-01-15T18:00:00+01:00"
)


@functools.cache
def look_at_due_date(assignment: str, due: datetime | None, log: Any) -> None:
    """Say, once, when that is here; warn if it was hardly meant (nbgrader.utils.parse_utc)."""
    if due is not None:
        here = f"{due.replace(tzinfo=UTC).astimezone():%Y-%m-%d %H:%M:%S %Z}"
        log.info("%s is due at %s UTC, %s here", assignment, due, here)
        if due.second:
            log.warning(ODD, assignment, due, here, assignment)


class LatePenalty(LateSubmissionPlugin):  # type: ignore[misc]
    """Takes points for each day begun after the due date and the grace."""

    per_day = Float(0.0, min=0, max=100, help="Per cent of the points for each day begun.").tag(
        config=True
    )
    grace_minutes = Float(0.0, min=0, help="Minutes after the due date that cost nothing.").tag(
        config=True
    )
    at_most = Float(100.0, min=0, max=100, help="No more per cent of the points than this.").tag(
        config=True
    )

    def late_submission_penalty(
        self, student_id: str, score: float, total_seconds_late: float
    ) -> float | None:
        """Return the points that are taken off; None if none are."""
        late = total_seconds_late - 60 * self.grace_minutes
        if late <= 0 or not self.per_day:
            return None
        days = math.ceil(late / DAY)
        return float(round(score * min(days * self.per_day, self.at_most) / 100, 2))
