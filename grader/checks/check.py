"""The mark of a check: what it is worth, what it asks, and in which scenarios.

@check(points=10, asks="decision", task=3, scenarios=("avoid_zones",))
def test_slow_zone(runs: Runs) -> None:
\"\"\"From 0.5 m to below 1.0 m the robot drives at 0.15 m/s.\"\"\"
follows(runs, "slow", help="0.5 m itself belongs to the slow zone.")
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import pytest

WIRING, DECISION, SAFETY, STATE, TIMING = ASKS = (
    "wiring",  # does the node run, with its topics?
    "decision",  # the right answer to an input
    "safety",  # nobody gets hurt
    "state",  # it remembers, and forgets
    "timing",  # in time
)

Mark = Callable[[Callable[..., Any]], Callable[..., Any]]


def check(
    *,
    asks: str,
    scenarios: Sequence[str],
    points: int = 0,
    task: int = 0,
    needs: Sequence[str] = ("wiring",),
    requires: Sequence[str] = (),
    hint: str = "",
    field: bool = False,
) -> Mark:
    """Return the mark of a check.

    Parameters
    ----------
    asks
        One of `ASKS`.
    scenarios
        Whose recordings it reads.
    points
        Of the exercise's 100; a field check has none.
    task
        The README's number; 0: all of them.
    needs
        Checks without which this one can't be judged, the wiring unless others are named; what
        they return is in `runs.handed`.
    requires
        Modules of optional libraries without which it isn't judged.
    hint
        Where its hint stands in hints.md: task and number, "3.1".
    field
        It counts for the badge only.

    Raises
    ------
    ValueError
        It asks none of the five.
    """
    if asks not in ASKS:
        raise ValueError(f"asks={asks!r}: expected one of {', '.join(ASKS)}")
    return pytest.mark.check(
        asks=asks,
        scenarios=tuple(scenarios),
        points=points,
        task=task,
        needs=tuple(needs),
        requires=tuple(requires),
        hint=hint,
        field=field,
    )
