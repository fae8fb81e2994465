"""The field checks of exercise 3: no points, but the badge *field-ready*."""

from __future__ import annotations

from grader.checks.old_field import FieldSuite
from grader.exercises.goal_seeking.contract import quests, ready_at
from grader.exercises.goal_seeking.evidence import (
    require_one_stop,
    require_rate,
    require_silence,
)
from grader.exercises.goal_seeking.reaching import require_reached
from grader.exercises.goal_seeking.turning import require_turns_toward
from grader.recording import Recording


def _require_contract(recording: Recording, help: str) -> None:
    """Fail unless the whole contract holds in this scenario; its verdicts need no further help."""
    require_silence(
        recording, 0.0, ready_at(recording), "before the node had both a pose and a goal"
    )
    for quest in quests(recording):
        require_reached(recording, quest)
        require_turns_toward(recording, quest)
        require_rate(recording, quest)
        require_one_stop(recording, quest)


field = FieldSuite("goal_seeking", _require_contract)

test_field_best_effort = field.best_effort("goal_field_best_effort", sensor="an odometry")
test_field_lost_odometry = field.check(
    "Reaches its goal when one odometry message in five is lost.", "goal_field_lost_odometry"
)
test_field_mirrored_world = field.mirrored_world("goal_field_mirrored")
test_field_fast_odometry = field.check(
    "Keeps to 10 Hz when odometry comes at 100 Hz.", "goal_field_fast_odometry"
)
