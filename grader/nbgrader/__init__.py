"""nbgrader with the judge behind it: marks come from driven nodes, not from executed cells.

`nbgrader_config.py` of a course says::

    from grader.nbgrader import configure

    configure(get_config())

From then on `nbgrader generate_assignment` leaves the skeletons of `%%node` cells, and `nbgrader
autograde` takes the students' `%%node` cells, has the judge drive them, and writes the points. No
cell of a student is ever executed. Settings (`c.JudgeNodes.…`): `trust`, `secret`.
"""

from __future__ import annotations

from typing import Any


def configure(config: Any) -> None:
    """Put the course's steps among nbgrader's own, in its configuration."""
    from grader.nbgrader.configuration import set_up  # noqa: PLC0415  (nbgrader: 1 s)

    set_up(config)
