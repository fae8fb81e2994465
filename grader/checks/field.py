"""The field suite: an exercise's whole contract on other robots and in other worlds."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partialmethod
from typing import Any

from grader.checks.case import Runs
from grader.checks.check import DECISION, check
from grader.checks.verbs import wired

BY_ANGLE = "Compute each beam's angle from angle_min and angle_increment, and wrap it to -π … π."
Check = Callable[[Runs], None]


@dataclass(frozen=True)
class FieldSuite:
    """Makes an exercise's field checks: no points, but the badge *field-ready*."""

    contract: Callable[[Runs, str], None]  # fails, with this help, unless it holds
    needs: tuple[str, ...] = ("wiring",)
    nodes: tuple[str, ...] = ()  # those that take part, where an exercise has several

    def check(self, *scenarios: str, title: str, help: str = "", **marked: Any) -> Check:
        """Return a check that the node is wired and keeps the contract in these scenarios."""

        def test(runs: Runs) -> None:
            wired(runs, *self.nodes)
            self.contract(runs, help)

        test.__doc__ = title
        mark = check(field=True, asks=DECISION, scenarios=scenarios, needs=self.needs, **marked)
        return mark(test)

    # the usual ones: other lidars, other worlds, other faults
    lds01 = partialmethod(
        check,
        title="Works with an LDS-01: beams from 0 to 2π, 0.0 for no return, 3.5 m, 5 Hz.",
        help=BY_ANGLE,
    )
    wide_lidar = partialmethod(
        check, title="Works with a lidar of 1080 beams over ±135° at 40 Hz.", help=BY_ANGLE
    )
    best_effort = partialmethod(
        check, title="Hears a lidar driver that publishes best effort (sensor-data QoS)."
    )
    mirrored_world = partialmethod(check, title="Does the same in a mirrored and rotated world.")
    speckle = partialmethod(check, title="Takes NaN speckle and noise in its stride.")
    lost_scans = partialmethod(check, title="Goes on when one scan in five is lost.")
