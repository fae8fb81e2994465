"""How linear.x gets faster: as much as it may from tick to tick, and never more."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from grader.checks.wiring import require_alive
from grader.exercises.safety_supervisor.contract import AS_ASKED, TOLERANCE, Habit, Tick, ticks
from grader.exercises.safety_supervisor.evidence import require_right
from grader.recording import Recording

HELP = (
    "The most is max(0, last) + 0.045, where last is what you published one tick ago, "
    "whatever the reason for it was."
)


def require_rises(recording: Recording, habit: Habit = AS_ASKED) -> None:
    """Fail unless linear.x rises by exactly as much as it may, wherever it should get faster.

    A node that still stands after a reason to stop is in no hurry: that reason's check judges it.
    """
    require_alive(recording)
    found = list(_under_way(ticks(recording, silences=True, habit=habit)))
    require_right(recording, found, lambda tick: tick.is_right, HELP)


def require_no_jumps(recording: Recording, habit: Habit = AS_ASKED) -> None:
    """Fail if linear.x rises by more than it may, also after a stop.

    That it rises more slowly, or not at all, or falls silent or dies, is for other checks to say.
    """
    found = [tick for tick in ticks(recording, habit=habit) if tick.rising]
    if found:
        require_right(recording, found, _is_no_jump, HELP)


def _under_way(found: Iterable[Tick]) -> Iterator[Tick]:
    """Yield the ticks at which linear.x should rise, once the node moves after its last stop."""
    moves = False
    for tick in found:
        moves = tick.moves or (moves and not tick.stops)
        if moves and tick.rising:
            yield tick


def _is_no_jump(tick: Tick) -> bool:
    return not tick.values[0] > max(decision.speed for decision in tick.right) + TOLERANCE
