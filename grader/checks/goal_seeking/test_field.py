"""The field checks of exercise 3: no points, but the badge *field-ready*."""

from __future__ import annotations

import pytest

from grader.checks.goal_seeking.contract import quests, ready_at
from grader.checks.goal_seeking.evidence import (
    require_one_stop,
    require_rate,
    require_reached,
    require_silence,
    require_turns_toward,
)
from grader.checks.wiring import require_alive, require_wiring
from grader.recording import Recording

Recordings = tuple[Recording, ...]


def _require_contract(recording: Recording) -> None:
    """Fail unless the whole contract holds in this scenario."""
    require_alive(recording)
    require_silence(
        recording, 0.0, ready_at(recording), "before the node had both a pose and a goal"
    )
    for quest in quests(recording):
        require_reached(recording, quest)
        require_turns_toward(recording, quest)
        require_rate(recording, quest)
        require_one_stop(recording, quest)


@pytest.mark.check(field=True, scenarios=("goal_field_best_effort",), needs=("wiring",))
def test_field_best_effort(recordings: Recordings) -> None:
    """Hears an odometry driver that publishes best effort (sensor-data QoS)."""
    for recording in recordings:
        require_wiring(recording, "goal_seeking")
        _require_contract(recording)


@pytest.mark.check(field=True, scenarios=("goal_field_lost_odometry",), needs=("wiring",))
def test_field_lost_odometry(recordings: Recordings) -> None:
    """Reaches its goal when one odometry message in five is lost."""
    for recording in recordings:
        _require_contract(recording)


@pytest.mark.check(field=True, scenarios=("goal_field_mirrored",), needs=("wiring",))
def test_field_mirrored_world(recordings: Recordings) -> None:
    """Does the same in a mirrored and rotated world."""
    for recording in recordings:
        _require_contract(recording)


@pytest.mark.check(field=True, scenarios=("goal_field_fast_odometry",), needs=("wiring",))
def test_field_fast_odometry(recordings: Recordings) -> None:
    """Keeps to 10 Hz when odometry comes at 100 Hz."""
    for recording in recordings:
        _require_contract(recording)
