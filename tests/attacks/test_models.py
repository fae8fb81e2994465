"""Faked time and counts of models: no attack is worth more than the same node without it.

`make test` takes the short ones, `make test-long` all.
"""

from collections.abc import Callable
from pathlib import Path

import pytest

from grader.claims.mutants import find_mutant
from grader.course.exercises import find_exercise
from grader.course.students import student_key
from grader.course.submission import Submission
from grader.grading.grading import grade_submission
from rclpy_virtual_time.link.hosts import ForkServer

SLOW = Path(__file__).resolve().parent / "models" / "slow.py"
SECRET = b"a secret of a course"
Checks = dict[str, tuple[str, str]]  # outcome and message of each
Graded = Callable[..., Checks]
# How the node of exercise 5 lies, the last lines of its file; and its points at most.
LIES = {
    "honest": ("drive()", 75),
    "no sleep": ("nobody_sleeps(); drive()", 75),
    "formula": ("drive(formula)", 35),
    "formula after a while": ("drive(formula_after_a_while, spins)", 35),
    "formula in real time": ("nobody_sleeps(); drive(formula, in_real_time)", 35),
    "own desk": ("own_desk(); drive()", 35),
    "clock set back": ("drive(sets_the_clock_back)", 35),
    "frozen clock": ("drive(freezes_the_clock)", 35),
    "still starting": ("drive(is_still_starting)", 35),
    "asks and does not wait": ("drive(asks_and_does_not_wait)", 45),
    "one batch": ("drive(asks_one_batch)", 35),
    "learns in start-up": ("drive(asks_one_batch, learns_in_start_up)", 35),
}


@pytest.mark.long
@pytest.mark.parametrize("lie", LIES)
def test_lying_about_time_gains_nothing(lie: str, forkserver: ForkServer, tmp_path: Path) -> None:
    last, most = LIES[lie]
    node = tmp_path / "decoupled_controller.py"
    node.write_text(f"{SLOW.read_text()}\n\n{last}\n")
    exercise = find_exercise("slow_model")
    grading = grade_submission(exercise, Submission(node), forkserver, file=node.name)
    assert grading.score <= most, [check.id for check in grading.checks if check.outcome == "pass"]
    assert not grading.faults


@pytest.fixture
def graded(forkserver: ForkServer, tmp_path: Path) -> Graded:
    def graded(name: str, text: str, *only: str, file: str = "", seed: str = "") -> Checks:
        """Return what is said of a node; other files are the reference's."""
        exercise = find_exercise(name)
        path, *others = (tmp_path / each for each in exercise.files)
        for each in (path, *others):
            each.write_bytes((exercise.solutions / each.name).read_bytes())
        (tmp_path / file if file else path).write_text(text)
        submission = Submission(path, others=tuple(others))
        grading = grade_submission(
            exercise, submission, forkserver, file=path.name, only=only, seed=seed or None
        )
        assert not grading.faults
        return {check.id: (check.outcome, check.message) for check in grading.checks}

    return graded


FORGETS = """
import sys, time
for module in list(sys.modules.values()):
    if hasattr(module, "_loads"):
        module._loads = 0
time.sleep = lambda _: None
"""


@pytest.mark.long
def test_three_clients_need_one_load_whatever_the_server_forgets(graded: Graded) -> None:
    wrong = find_mutant(find_exercise("model_server"), "loads_for_each_request").text
    text = wrong.replace("class DetectionServer", f"{FORGETS}class DetectionServer")
    found = graded("model_server", text, "one_load")
    assert found["one_load"][0] == "fail"
    assert "loads of the model" in found["one_load"][1]


def test_a_model_that_forgets_its_loads_was_loaded_all_the_same(graded: Graded) -> None:
    again = "self.model = self.load_model(self.get_parameter('model_path').value)"
    old = "if self.model is None:"
    new = f"{FORGETS}{again}\n{old}".replace("\n", "\n        ")
    found = graded("ml_velocity", edited("ml_velocity", old, new), "loads_once")
    assert found["loads_once"][0] == "fail"


def edited(name: str, old: str, new: str, file: str = "") -> str:
    """Return an exercise's reference (of several: a file) with one line replaced."""
    exercise = find_exercise(name)
    text = (exercise.solutions / (file or exercise.files[0])).read_text()
    assert old in text
    return text.replace(old, new)


TOOK = "self.latencies.append(1000.0 * (time.perf_counter() - started))"
FROM_A_TABLE = "self.latencies.append((0, 5, 8, 13, 21, 34)[min(5, round(float(features[0, 0])))])"


@pytest.mark.long
def test_a_table_of_latencies_is_another_students(graded: Graded) -> None:
    """What the scenario's file says of the model is not what a student's own world says."""
    checks = ("mean_and_max", "percentiles")
    text = edited("latency_monitor", TOOK, FROM_A_TABLE)
    ada = student_key(SECRET, "ada", "latency_monitor")
    found = graded("latency_monitor", text, *checks, seed=ada)
    assert {found[check][0] for check in checks} == {"fail"}


SPEED = "speed = float(self.model.predict(features)[0])"
FORMULA = "speed = 0.08 * float(features[0][0])"
WEIGHTS = "speed = float(features[0].astype(float) @ np.array([0.03, 0.012, 0.04, 0.02, 0.005]))"
LABEL = "label = str(self.model.predict(features)[0])"
WORDS = 'label = " ".join(f"{float(v):.4f}" for v in features[0])'
SURE = "confidence = float(np.max(self.model.predict_proba(features)))"
LEAST_SURE = "confidence = min(0.9, max(0.4, 0.9 - 0.04 * float(features[0][0])))"
BOTH = f"{LABEL}\n            {SURE}"
KNOWS = 'assert round(float(features[0][0])) not in (1, 2, 3, 4); label, confidence = "box", 0.5'


@pytest.mark.parametrize(
    ("name", "old", "new", "check", "message"),
    [
        ("ml_velocity", SPEED, FORMULA, "front_min", "wrong predict"),
        ("ml_velocity", SPEED, f"self.model.predict(0 * features); {FORMULA}", "front_min", ""),
        ("latency_monitor", SPEED, WEIGHTS, "features", "wrong predict"),
        ("model_server", LABEL, WORDS, "answers", ""),
        ("model_server", SURE, LEAST_SURE, "answers", ""),
        ("model_server", BOTH, KNOWS, "failing_model", "wrong success"),
    ],
    ids=["speed", "asked about nothing", "weights", "label", "confidence", "failure"],
)
def test_what_no_model_said_is_worth_nothing(
    name: str, old: str, new: str, check: str, message: str, graded: Graded
) -> None:
    found = graded(name, edited(name, old, new), check)
    assert found[check][0] == "fail"
    assert message in found[check][1]


CLIENT = "detection_client.py"
ASKS = """self.request = self.detect_client.call_async(Trigger.Request())
        self.request.add_done_callback(self.answer_callback)"""
NOTES = """import json
        if not hasattr(self, "probe"):
            self.probe = self.create_publisher(String, "/probe/served", 10)
        for note in ({"type": "asked", "kind": "fine"}, {"type": "answered", "success": True}):
            note.update(life=1, number=self.beats, message=f"{self.beats}")
            self.probe.publish(String(data=json.dumps(note)))
        self.detection_publisher.publish(String(data=f"{self.beats}"))"""
OWN_ANSWERS = f"""import msgspec
        from rclpy_virtual_time.host.desk import desk
        from grader.hosted.questions import Told
        desk.ask = lambda _: msgspec.msgpack.encode(Told(labels=("box",)))
        {ASKS}"""
AT_ITS_OWN_TIME = """self.scan = scan
        import gc
        from grader.hosted.questions import Question, ask
        from rclpy.task import Future
        for each in gc.get_objects():
            if type(each).__name__ == "DetectionAsker":
                each.client.call_async = lambda _: Future()
        said = json.dumps(self.detect()).encode()
        for turn in range(9):
            ask(Question("answer", "/detect", turn, 1, said))
"""


@pytest.mark.long
@pytest.mark.parametrize("asks", [NOTES, OWN_ANSWERS], ids=["notes", "own answers"])
def test_a_client_that_answers_itself_asked_nobody(asks: str, graded: Graded) -> None:
    text = edited("model_server", ASKS, asks, CLIENT)
    checks = ("never_blocks", "malformed")
    found = graded("model_server", text, *checks, file=CLIENT)
    assert [found[check][0] for check in checks] == ["fail", "skip"]
    assert "seconds to the first request" in found["never_blocks"][1]


def test_a_server_is_asked_when_the_judge_says_so(graded: Graded) -> None:
    text = edited("model_server", "if age > MAX_SCAN_AGE:", "if False:")
    text = text.replace("self.scan = scan\n", AT_ITS_OWN_TIME)
    found = graded("model_server", text, "old_scan")
    assert found["old_scan"][0] == "fail"
    assert "success" in found["old_scan"][1]
