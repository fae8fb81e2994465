"""The mark of a check: what it is worth, what it asks, and in which scenarios.

@check(points=10, asks="decision", task=3, scenarios=("avoid_zones",))
def test_slow_zone(runs: Runs) -> None:
\"\"\"From 0.5 m to below 1.0 m the robot drives at 0.15 m/s.\"\"\"
follows(runs, "slow", help="0.5 m itself belongs to the slow zone.")
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Final, Literal

import pytest

Asks = Literal["wiring", "decision", "safety", "state", "timing"]
WIRING: Final = "wiring"  # does the node run, with its topics?
DECISION: Final = "decision"  # the right answer to an input
SAFETY: Final = "safety"  # nobody gets hurt
STATE: Final = "state"  # it remembers, and forgets
TIMING: Final = "timing"  # in time

Mark = Callable[[Callable[..., Any]], Callable[..., Any]]


def check(
    *,
    asks: Asks,
    scenarios: Sequence[str],  # whose recordings it reads
    points: int = 0,  # of the exercise's 100; a field check has none
    task: int = 0,  # the README's number; 0: all of them
    needs: Sequence[str] = ("wiring",),  # checks without which this one can't be judged
    requires: Sequence[str] = (),  # modules of optional libraries without which it isn't judged
    hint: str = "",  # where it stands in hints.md: task and number, "3.1"
    field: bool = False,  # it counts for the badge only
) -> Mark:
    """Return the mark of a check."""
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
