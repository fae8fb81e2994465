"""The models that the judge keeps: answers come when their time is over, and are counted."""

import copy
import pickle
from collections.abc import Callable
from pathlib import Path

import msgspec
import numpy as np
import pytest
from msgspec.structs import replace

from grader.errors import GraderError
from grader.hosted.questions import MAX_ROWS, Question, Told
from grader.hosted.supplied import kept
from grader.models.files import is_kept, probe, write_models
from grader.models.service import IN_START_UP, MAX_ASKED, MOST_ROWS, ModelService, TooManyQuestions
from rclpy_virtual_time import HostForged
from rclpy_virtual_time.host import frames
from rclpy_virtual_time.host.desk import desk
from sim.messages import Message, laser_scan
from sim.scenario import Model, Scenario
from sim.scenario_files import load_scenario

MS = 1_000_000
LEADER = load_scenario("slow_leader")
FILE = "velocity_model.pkl"
ROW = np.array([[2.0, 3.0, 0.5, 4.0, 5.0]])


def sent(asked: Question, number: int = 0) -> frames.Question:
    return frames.Question(number, msgspec.msgpack.encode(asked))


def heard(told: frames.Told) -> Told:
    return msgspec.msgpack.decode(told.data, type=Told)


def at_once(models: ModelService) -> Callable[[bytes], bytes]:
    """Return how a program asks models in its start-up."""
    return lambda data: models.at_once(frames.Question(0, data)).data


def question(
    method: str, number: int = 0, load: int = 1, rows: np.ndarray = ROW
) -> frames.Question:
    if method == "load":
        return sent(Question(method, FILE), number)
    return sent(Question(method, FILE, load, len(rows), rows.tobytes()), number)


def service(scenario: Scenario = LEADER, seed: int | None = None) -> ModelService:
    return ModelService(scenario, scenario.seed if seed is None else seed)


def scan(distance: float) -> Message:
    """One reading all around."""
    return laser_scan(
        time=0,
        ranges=np.full(360, distance, np.float32),
        angle_min=-np.pi,
        angle_increment=np.pi / 180,
        range_min=0.15,
        range_max=12.0,
    )


def said(answer: frames.Told) -> np.ndarray:
    told = heard(answer)
    return np.frombuffer(told.numbers).reshape(told.shape)


def test_an_answer_is_due_when_the_models_time_is_over() -> None:
    models = service()
    models.ask(question("load"), 0)
    models.ask(question("predict", 7), 13 * MS)

    assert [heard(told).load for _, told in models.due(0)] == [1]
    assert models.next_due == 213 * MS
    assert models.due(213 * MS - 1) == []
    ((_, told),) = models.due(213 * MS)
    assert told.number == 7
    assert said(told) == pytest.approx([0.08])
    load, call = models.inferences
    assert load.is_load
    assert (call.asked, call.answered, call.said) == (13 * MS, 213 * MS, (0.08,))


def test_a_program_waits_for_a_time_of_the_trial_whenever_it_began() -> None:
    until = sent(Question("until", "", 460 * MS))
    assert service().at_once(until).wait == 460 * MS
    live = ModelService(LEADER, LEADER.seed, began=None)
    live.ask(until, 5_000 * MS)  # before the trial begins
    assert live.next_due is None
    live.begin(7_000 * MS)
    assert live.next_due == 7_460 * MS
    live.ask(until, 7_900 * MS)  # its time is over
    assert [heard(told) for _, told in live.due(7_900 * MS)] == [Told(), Told()]


def test_before_the_scenario_answers_say_what_the_model_takes() -> None:
    models = service()
    models.at_once(question("load"))
    told = models.at_once(question("predict"))

    assert told.wait == 200 * MS
    assert {i.asked for i in models.inferences} == {IN_START_UP}
    assert models.next_due is None


@pytest.mark.parametrize(
    ("asked", "problem"),
    [
        (question("predict", load=0), "was not loaded"),
        (question("predict", load=2), "was not loaded"),
        (sent(Question("predict", "other.pkl", 1, 1, ROW.tobytes())), "no model other.pkl"),
        (sent(Question("predict", FILE, 1, 2, ROW.tobytes())), "shape"),
        (sent(Question("predict", FILE, 1, 1, b"odd")), "shape"),
        (sent(Question("predict_proba", FILE, 1, 1, ROW.tobytes())), "predict_proba"),
    ],
)
def test_what_no_model_can_answer_is_a_problem(asked: frames.Question, problem: str) -> None:
    models = service()
    models.at_once(question("load"))
    assert problem in heard(models.at_once(asked)).problem


def test_loads_are_counted_by_the_judge() -> None:
    models = service(load_scenario("ml_loads_once"))
    models.ask(question("load"), 0)
    assert models.next_due == 80 * MS
    models.ask(question("load"), 90 * MS)
    answers = [heard(told).load for _, told in models.due(10**12)]
    told = models.at_once(question("predict"))

    assert answers == [1, 2]
    assert said(told) == pytest.approx([0.2])


def test_a_model_that_raises_takes_its_time_too() -> None:
    models = service(load_scenario("latency_raises"))
    models.at_once(question("load"))
    near = np.array([[1.0, 1.0, 0.0, 1.0, 1.0]])
    answer = models.at_once(question("predict", rows=near))
    told = heard(answer)

    assert "can't say anything" in told.problem
    assert told.error == "TypeError"
    assert answer.wait == 30 * MS
    assert models.inferences[-1].failed

    far = np.array([[7.0, 7.0, 0.0, 7.0, 7.0]])  # what is said takes a time of its own
    assert models.at_once(question("predict", rows=far)).wait == 5 * MS


def test_a_model_raises_what_its_settings_name(monkeypatch: pytest.MonkeyPatch) -> None:
    settings = {"distance": 3.0, "raises": "RuntimeError TypeError"}
    node = replace(LEADER.node, models={FILE: Model("raises_near", settings)})
    monkeypatch.setattr(desk, "ask", at_once(service(replace(LEADER, node=node))))
    model = kept.load(kept.Kept, FILE)
    for distance, kind in ((0.2, RuntimeError), (1.0, TypeError), (2.6, TypeError)):
        with pytest.raises(kind, match="can't say anything"):
            model.predict([[distance, 3.0, 0.5, 4.0, 5.0]])


def test_times_by_distance_differ_between_students_a_little() -> None:
    scenario = load_scenario("latency_times")

    def took(seed: int) -> int:
        models = service(scenario, seed)
        models.at_once(question("load"))
        return models.at_once(question("predict")).wait

    assert took(scenario.seed) == 8 * MS
    others = {took(seed) for seed in range(100, 110)}
    assert len(others) == 10
    assert all(7.6 * MS < other < 8.4 * MS for other in others)


def test_a_quick_row_does_not_hide_a_slow_one() -> None:
    models = service(load_scenario("latency_times"))
    (file,) = models.scenario.node.models
    model = models.scenario.node.models[file].settings["seconds"]
    models.at_once(sent(Question("load", file)))

    def took(*metres: float) -> int:
        rows = np.repeat(np.array(metres, dtype=float)[:, None], 5, axis=1)
        return models.at_once(sent(Question("predict", file, 1, len(rows), rows.tobytes()))).wait

    times = [took(metres) for metres in range(1, len(model))]
    assert len(set(times)) > 1
    assert took(*range(1, len(model))) == max(times)
    assert took(*range(len(model) - 1, 0, -1)) == max(times)


def test_nobody_asks_without_end() -> None:
    with pytest.raises(TooManyQuestions):
        models = service()
        for _ in range(MAX_ASKED + 1):
            models.at_once(sent(Question("load", "none.pkl")))
    models = service()
    with pytest.raises(TooManyQuestions, match="rows"):
        for _ in range(MOST_ROWS // MAX_ROWS + 1):
            models.at_once(sent(Question("predict", "none.pkl", 1, MAX_ROWS)))
    assert sum(len(inference.said) for inference in models.inferences) <= MOST_ROWS


# --- the node's side ------------------------------------------------------------------------------


def test_a_kept_model_is_loaded_and_asked_like_any_other(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    models = service()
    write_models(LEADER.node.models, tmp_path)
    content = (tmp_path / FILE).read_bytes()
    assert b"0.04" not in content
    monkeypatch.setattr(desk, "ask", at_once(models))
    model = pickle.loads(content)

    assert model.predict([[2.0, 3.0, 0.5, 4.0, 5.0]]) == pytest.approx([0.08])
    assert model.predict(ROW.astype(np.float32).repeat(3, axis=0)).shape == (3,)
    for wrong in ([2.0, 3.0], [[1.0]], np.zeros((0, 5))):
        with pytest.raises(ValueError, match="shape"):
            model.predict(wrong)
    for other in (copy.copy(model), copy.deepcopy(model)):
        assert other.predict(ROW) == pytest.approx([0.08])
    assert sum(i.is_load for i in models.inferences) == 1
    three = service(load_scenario("ml_clip"))  # a model that wants three features
    monkeypatch.setattr(desk, "ask", at_once(three))
    assert kept.load(kept.Kept, FILE).predict(ROW[:, :3]) == pytest.approx([9.9])


def test_outside_a_trial_nobody_answers_and_no_model_lies_outside(tmp_path: Path) -> None:
    with pytest.raises(RuntimeError, match="in a trial"):
        kept.Kept(FILE, 1).predict(ROW)
    for name in ("../model.pkl", "/model.pkl", "a/../../model.pkl"):
        with pytest.raises(GraderError, match="working folder"):
            write_models({name: Model("empty", {})}, tmp_path / "node")


@pytest.mark.parametrize("scenario", ["detect_numbers", "detect_answers"])
def test_a_classifier_says_what_it_would_say_in_the_node(
    scenario: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    models = service(load_scenario(scenario))
    file, spec = next(iter(models.scenario.node.models.items()))
    monkeypatch.setattr(desk, "ask", at_once(models))
    model, there = kept.load(kept.KeptClassifier, file), probe(spec)
    for method in ("predict", "predict_proba"):
        here, right = getattr(model, method)(ROW), getattr(there, method)(ROW)
        assert here.dtype == right.dtype
        assert here.tolist() == right.tolist()
    _, label, sure = models.inferences
    assert [str(x) for x in (*label.labels, *map(int, label.said))] == [str(model.predict(ROW)[0])]
    assert sure.said == pytest.approx([model.predict_proba(ROW).max()])


@pytest.mark.parametrize(
    ("name", "model", "is_ours"),
    [
        ("velocity_model.pkl", Model("echo", {"feature": 0}), True),
        ("Model.Pkl", Model("weighted", {"weights": (1.0,)}), True),
        ("policy.onnx", Model("raises_near", {"distance": 1.0}), False),
        ("velocity_model.pkl", Model("linear", {"weights": (1.0,)}), False),
        ("velocity_model.pkl", Model("garbage", {}), False),
        ("velocity_model.pkl", Model("trained", {}), False),
    ],
)
def test_every_probe_in_a_pickle_stays_with_the_judge(
    name: str, model: Model, is_ours: bool
) -> None:
    assert is_kept(name, model) == is_ours


def test_features_that_are_no_scans_are_those_of_the_newest_if_any_will_do() -> None:
    """A row of a scan that has come is about that scan; anything else about the newest."""
    model = LEADER.node.models[FILE]
    came: list[Message] = []
    any_will_do, strict = (
        ModelService(replace(LEADER, node=replace(LEADER.node, models={FILE: each})), 0, came)
        for each in (model, replace(model, any_features=False))
    )
    near, far = ([d, d, 0.0, d, d] for d in (1.0, 3.0))
    for models in (any_will_do, strict):
        models.at_once(question("load"))

    def asked(*row: float, rows: int = 1) -> tuple[float, ...]:
        given = np.array(row)
        about = sent(Question("predict", FILE, 1, rows, given.tobytes()))
        strict.at_once(about)
        any_will_do.at_once(about)
        return any_will_do.inferences[-1].said

    assert asked(9.0, 0.0, 0.0, 0.0, 0.0) == pytest.approx((0.36,))  # before the first scan
    for distance in (1.0, 3.0):
        came.append(scan(distance))
    assert asked(*near) == pytest.approx((0.04,))  # an older scan, and asked about
    assert strict.inferences[-1].said == pytest.approx((0.04,))
    assert asked(*far) == pytest.approx((0.12,))
    assert asked(0.0, 0.0, 0.0, 0.0, 9.0) == pytest.approx((0.12,))
    assert strict.inferences[-1].said == (0.0,)
    assert asked(*far, rows=5) == pytest.approx((0.12,) * 5)  # a row in place of a table
    assert strict.inferences[-1].failed

    came.append(scan(np.nan))  # it has no features
    assert asked(0.0, 0.0, 0.0, 0.0, 9.0) == pytest.approx((0.12,))


@pytest.mark.parametrize("more", [b"\xc1", b"\x91" * 200_000 + b"\xc0"], ids=["no frame", "deep"])
def test_what_is_no_question_is_forged(more: bytes) -> None:
    """Whatever a program sends, the judge says so and goes on."""
    data = b"\x96" + sent(Question("load", FILE)).data[1:] + more
    with pytest.raises(HostForged):
        ModelService(LEADER, 1).ask(frames.Question(0, data), 0)
