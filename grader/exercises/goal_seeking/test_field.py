"""The field checks of exercise 3: no points, but the badge *field-ready*."""

from __future__ import annotations

from grader.checks.case import Runs
from grader.checks.check import SAFETY, check
from grader.checks.field import FieldSuite
from grader.checks.verbs import follows
from grader.exercises.goal_seeking.contract import quests
from grader.exercises.goal_seeking.test_core import SPEED_TOLERANCE
from grader.exercises.goal_seeking.ways import keeps_time, reaches, stands_without_odometry


def _keeps_the_contract(runs: Runs, help: str) -> None:
    """Fail unless the whole contract holds in these scenarios."""
    for recording in runs:
        for quest in quests(recording):
            reaches(recording, quest)
        keeps_time(recording)
    follows(runs, help=help, tolerance=SPEED_TOLERANCE)


field = FieldSuite(_keeps_the_contract)

test_field_best_effort = field.best_effort(
    "goal_field_best_effort",
    title="Hears an odometry driver that publishes best effort (sensor-data QoS).",
)
test_field_lost_odometry = field.check(
    "goal_field_lost_odometry", title="Reaches its goal when one odometry message in five is lost."
)
test_field_mirrored_world = field.mirrored_world("goal_field_mirrored")
test_field_fast_odometry = field.check(
    "goal_field_fast_odometry", title="Keeps to 10 Hz when odometry comes at 100 Hz."
)


@check(field=True, asks=SAFETY, scenarios=("goal_field_odometry_stops",))
def test_field_odometry_stops(runs: Runs) -> None:
    """Stands when no odometry has come for half a second, and drives on when it is back."""
    for recording in runs:
        stands_without_odometry(recording)
