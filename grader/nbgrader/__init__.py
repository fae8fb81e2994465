"""nbgrader backed by the judge: marks come from driven nodes, not from executed cells.

A course's `nbgrader_config.py` says::

    from grader.nbgrader import configure

    configure(get_config())

Then `nbgrader generate_assignment` leaves the skeletons of `%%node` cells, and `nbgrader autograde`
has the judge drive the students' `%%node` cells and writes the points. No student's cell is ever
executed. Settings (`c.JudgeNodes.…`): `trust`, `secret`.
"""

from typing import Any


def configure(config: Any) -> None:
    """Add the course's steps to nbgrader's own, in its configuration."""
    from grader.nbgrader.configuration import set_up  # noqa: PLC0415  (nbgrader: 1 s)

    set_up(config)
