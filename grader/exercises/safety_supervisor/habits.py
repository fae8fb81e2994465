"""What a node does wrong with the button or the timer: a mistake is named, and paid for, once.

`e_stop` judges it, and no node with another habit than the contract's passes that check. All other
checks take the habit as given, each where the habit does not hide what the check is about:
`never_delays` and `acceleration` are about deciding at each tick, so they take only the button's.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import lru_cache

from grader.checks.verdict import CheckFailed
from grader.exercises.safety_supervisor.contract import AS_ASKED, Habit, Tick, ticks
from grader.exercises.safety_supervisor.evidence import require_e_stop
from grader.recording import Recording

SHOWS = "safe_e_stop"  # a false comes, and later true and false in turns
_WRONG = (Habit(pressed="any"), Habit(pressed="at first"), Habit(held=True))


def habit_of(recordings: Iterable[Recording]) -> Habit:
    """Return the one wrong habit that explains all commands in `safe_e_stop`, or the contract's."""
    (shows,) = (recording for recording in recordings if recording.name == SHOWS)
    return _habit_in(shows)


@lru_cache(maxsize=2)  # nearly every check asks
def _habit_in(shows: Recording) -> Habit:
    try:
        require_e_stop(shows)
    except CheckFailed:
        return next((habit for habit in _WRONG if _explains(habit, shows)), AS_ASKED)
    return AS_ASKED


def button_of(recordings: Iterable[Recording]) -> Habit:
    """Return the same, but for a node that decides only now and then: the contract's."""
    return habit_of(recordings)._replace(held=False)


def _explains(habit: Habit, shows: Recording) -> bool:
    found = ticks(shows, silences=True, habit=habit)
    return bool(found) and all(map(_is_right, found))


def _is_right(tick: Tick) -> bool:
    return tick.is_right_but_for_the_rise
