"""The field suite: the whole contract of an exercise on other robots and in other worlds.

The `test_field.py` of an exercise declares its field checks, and in which scenarios each runs:

    field = FieldSuite(_keeps_the_contract)
    test_field_lds01 = field.lds01("avoid_field_lds01_bench", "avoid_field_lds01")
    test_field_best_effort = field.best_effort("avoid_field_best_effort")

Each is a test like any other: it carries the mark of a check, and its docstring is its title.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from grader.checks.case import Runs
from grader.checks.check import DECISION, check
from grader.checks.words import wired

BY_ANGLE = "Compute each beam's angle from angle_min and angle_increment, and wrap it to -π … π."
Check = Callable[[Runs], None]


@dataclass(frozen=True)
class FieldSuite:
    """Makes an exercise's field checks: no points, but the badge *field-ready*."""

    contract: Callable[[Runs, str], None]  # fails, with this help, unless it holds
    needs: tuple[str, ...] = ("wiring",)
    nodes: tuple[str, ...] = ()  # those that take part, where an exercise has several

    def check(
        self,
        title: str,
        *scenarios: str,
        help: str = "",
        requires: tuple[str, ...] = (),
        hint: str = "",
    ) -> Check:
        """Return a check that the node is wired and keeps the contract in these scenarios."""

        @check(
            field=True,
            asks=DECISION,
            scenarios=scenarios,
            needs=self.needs,
            requires=requires,
            hint=hint,
        )
        def test(runs: Runs) -> None:
            wired(runs, *self.nodes)
            self.contract(runs, help)

        test.__doc__ = title
        return test

    def lds01(self, *scenarios: str, requires: tuple[str, ...] = (), hint: str = "") -> Check:
        """Return a check with the lidar of a TurtleBot3."""
        title = "Works with an LDS-01: beams from 0 to 2π, 0.0 for no return, 3.5 m, 5 Hz."
        return self.check(title, *scenarios, help=BY_ANGLE, requires=requires, hint=hint)

    def wide_lidar(self, *scenarios: str, requires: tuple[str, ...] = (), hint: str = "") -> Check:
        """Return a check with a fast and fine lidar that does not see behind the robot."""
        title = "Works with a lidar of 1080 beams over ±135° at 40 Hz."
        return self.check(title, *scenarios, help=BY_ANGLE, requires=requires, hint=hint)

    def best_effort(
        self, *scenarios: str, sensor: str = "a lidar", help: str = "", hint: str = ""
    ) -> Check:
        """Return a check with a driver that a reliable subscription does not hear."""
        title = f"Hears {sensor} driver that publishes best effort (sensor-data QoS)."
        return self.check(title, *scenarios, help=help, hint=hint)

    def mirrored_world(
        self,
        *scenarios: str,
        title: str = "Does the same in a mirrored and rotated world.",
        help: str = "",
    ) -> Check:
        """Return a check in a world that no node can have learnt by heart.

        A task that knows left from right (follow the wall on your right) is not the same in a
        mirror: give scenarios that are only rotated (`rotate_deg`), and a title that says so.
        """
        return self.check(title, *scenarios, help=help)

    def speckle(
        self,
        *scenarios: str,
        title: str = "Takes NaN speckle and noise in its stride.",
        help: str = "",
        requires: tuple[str, ...] = (),
    ) -> Check:
        """Return a check with a lidar of which some beams read NaN."""
        return self.check(title, *scenarios, help=help, requires=requires)

    def lost_scans(
        self,
        *scenarios: str,
        title: str = "Goes on when one scan in five is lost.",
        help: str = "",
        requires: tuple[str, ...] = (),
    ) -> Check:
        """Return a check in which one scan in five never arrives."""
        return self.check(title, *scenarios, help=help, requires=requires)
