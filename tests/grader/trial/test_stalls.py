"""What a node usually answers."""

from grader.trial.stalls import ENOUGH, AnswerRate

SCAN, ODOM = frozenset({"/scan"}), frozenset({"/odom"})


def test_a_habit_takes_some_time_and_forgives_some_exceptions() -> None:
    rate = AnswerRate()
    for _ in range(ENOUGH - 1):
        rate.note(SCAN, answered=True)
        assert not rate.answers(SCAN)
    rate.note(SCAN, answered=False)
    assert rate.answers(SCAN)

    rate.note(SCAN, answered=False)
    assert not rate.answers(SCAN)


def test_each_kind_of_event_has_a_habit_of_its_own() -> None:
    rate = AnswerRate()
    for _ in range(ENOUGH):
        rate.note(SCAN, answered=True)
        rate.note(ODOM, answered=False)
    assert rate.answers(SCAN)
    assert not rate.answers(ODOM)
    assert not rate.answers(SCAN | ODOM)
