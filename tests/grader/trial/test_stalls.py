"""What a node usually answers."""

from grader.trial.stalls import ENOUGH, Habit

SCAN, ODOM = frozenset({"/scan"}), frozenset({"/odom"})


def test_a_habit_takes_some_time_and_forgives_some_exceptions() -> None:
    habit = Habit()
    for _ in range(ENOUGH - 1):
        habit.note(SCAN, answered=True)
        assert not habit.answers(SCAN)
    habit.note(SCAN, answered=False)
    assert habit.answers(SCAN)

    habit.note(SCAN, answered=False)
    assert not habit.answers(SCAN)


def test_each_kind_of_event_has_a_habit_of_its_own() -> None:
    habit = Habit()
    for _ in range(ENOUGH):
        habit.note(SCAN, answered=True)
        habit.note(ODOM, answered=False)
    assert habit.answers(SCAN)
    assert not habit.answers(ODOM)
    assert not habit.answers(SCAN | ODOM)
