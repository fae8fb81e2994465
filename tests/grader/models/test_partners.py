"""The grader's ends of exercise 6's service: what the judge answers, and when it lets ask."""

import msgspec
import pytest
from test_service import MS, sent

from grader.hosted.questions import Question, Told
from grader.models.partners import NEVER, SERVICE
from grader.models.service import ModelService, TooManyQuestions
from rclpy_virtual_time import Settled
from rclpy_virtual_time.host import frames
from sim.scenario import Scenario
from sim.scenario_files import load_scenario

RESTART, LATE = load_scenario("detect_restart"), load_scenario("detect_late_scans")
REQUEST, TURN = sent(Question("request", SERVICE)), sent(Question("turn", SERVICE))


def service(scenario: Scenario = LATE, began: int | None = 0) -> ModelService:
    return ModelService(scenario, scenario.seed, began=began)


def answer(turn: int, message: str = "box") -> frames.Question:
    return sent(Question("answer", SERVICE, turn, 1, message.encode()))


def test_an_answer_counts_once_and_for_a_time_that_has_come() -> None:
    models = service()
    models.ask(answer(0), 0)  # nobody has been asked
    models.ask(TURN, 0)
    assert models.next_due == 0
    models.due(0)
    assert models.next_due == 750 * MS
    models.ask(answer(0, "first"), 760 * MS)
    models.ask(answer(0, "second"), 770 * MS)
    models.ask(answer(7), 780 * MS)
    (note,) = models.inferences
    assert (note.asked, note.answered, note.labels) == (750 * MS, 760 * MS, ("first", "true"))


def test_no_server_answers_before_it_starts_and_after_it_was_killed() -> None:
    models = service(RESTART)
    for at in (1_200, 1_300, 2_500, 2_700):
        models.ask(REQUEST, at * MS)
    early, killed = models.due(1_200 * MS), models.due(2**60)
    assert [msgspec.msgpack.decode(told.data, type=Told).problem for _, told in early] == [
        "there is no scan yet"
    ]
    assert len(killed) == 2  # that of 1.3 s, and the refusal of 2.7 s
    first, second = models.inferences
    assert (first.answered, second.answered >= NEVER) == (1_500 * MS, True)


def test_in_real_time_turns_wait_for_the_beginning_and_requests_are_refused() -> None:
    models, early = service(began=None), service(RESTART, None)
    for _ in range(Settled.MAX_QUESTIONS):
        models.ask(TURN, 5)
    with pytest.raises(TooManyQuestions):
        models.ask(TURN, 6)
    early.ask(REQUEST, 1_400 * MS)
    assert (models.next_due, early.inferences) == (None, [])
    models.begin(1_000 * MS)
    assert models.next_due == 1_750 * MS


def test_two_students_get_other_answers() -> None:
    first, second = service(RESTART), ModelService(RESTART, RESTART.seed + 1)
    for models in (first, second):
        models.ask(REQUEST, 1_300 * MS)
    assert first.inferences[0].labels != second.inferences[0].labels
