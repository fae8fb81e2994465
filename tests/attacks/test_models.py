"""Faked time and counts of models: no attack is worth more than the same node without it.

Nor is doing little, which breaks no rule while nobody looks (`lazy`).

`make test` takes two of them, `make test-long` all.
"""

import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from grader.authoring.mutants import mutants
from grader.course.exercises import find_exercise
from grader.course.students import student_key
from grader.course.submission import Submission
from grader.grading.grading import grade_submission
from grader.link.hosts import ForkServer
from sim.messages import EPOCH_NS

HERE = Path(__file__).resolve().parent / "models"
NAIVE = HERE / "naive.py"
LAZY = HERE.with_name("lazy")
ATTACKS = sorted({*HERE.glob("*.py"), *LAZY.glob("*.py")} - {NAIVE})
QUICK = ("ml_forgotten_loads", "latency_of_no_call")
SECRET = b"a secret of a course"


@pytest.fixture(scope="module")
def forkserver() -> Iterator[ForkServer]:
    with ForkServer(EPOCH_NS) as forkserver:
        yield forkserver


def read(path: Path) -> dict[str, str]:
    return dict(re.findall(r"^(exercise|only|score|student): (.+)$", path.read_text(), re.M))


@pytest.mark.parametrize(
    "path",
    [pytest.param(p, id=p.stem, marks=[pytest.mark.long] * (p.stem not in QUICK)) for p in ATTACKS],
)
def test_lying_about_time_and_counts_gains_nothing(path: Path, forkserver: ForkServer) -> None:
    claim = read(path)
    key = student_key(SECRET, claim["student"], claim["exercise"]) if "student" in claim else None
    grading = grade_submission(
        find_exercise(claim["exercise"]),
        Submission(path, others=(NAIVE,)),
        forkserver,
        file=path.name,
        only=[name.strip() for name in claim["only"].split(",")] if "only" in claim else (),
        seed=key,
    )
    assert grading.score <= int(claim["score"]), [
        check.id for check in grading.checks if check.outcome == "pass"
    ]
    assert not grading.faults


FORGETS = """
import sys, time
for module in list(sys.modules.values()):
    if hasattr(module, "_loads"):
        module._loads = 0
time.sleep = lambda _: None
"""


@pytest.mark.long
def test_three_clients_need_one_load_whatever_the_server_forgets(
    forkserver: ForkServer, tmp_path: Path
) -> None:
    exercise = find_exercise("model_server")
    (wrong,) = [m for m in mutants(exercise) if m.name == "loads_for_each_request"]
    server, client = (tmp_path / file for file in exercise.files)
    server.write_text(
        wrong.text.replace("class DetectionServer", f"{FORGETS}class DetectionServer")
    )
    client.write_bytes((exercise.solutions / client.name).read_bytes())
    grading = grade_submission(
        exercise,
        Submission(server, others=(client,)),
        forkserver,
        file=server.name,
        only=("one_load",),
    )
    one_load = next(check for check in grading.checks if check.id == "one_load")
    assert one_load.outcome == "fail"
    assert "was loaded" in one_load.message


def graded(
    forkserver: ForkServer, folder: Path, name: str, old: str, new: str, only: tuple[str, ...]
) -> dict[str, tuple[str, str]]:
    """Return outcome and message of each check for the reference with one line replaced."""
    exercise = find_exercise(name)
    path, *others = (folder / file for file in exercise.files)
    text = (exercise.solutions / path.name).read_text()
    assert old in text
    path.write_text(text.replace(old, new))
    for other in others:
        other.write_bytes((exercise.solutions / other.name).read_bytes())
    submission = Submission(path, others=tuple(others))
    grading = grade_submission(exercise, submission, forkserver, file=path.name, only=only)
    assert not grading.faults
    return {check.id: (check.outcome, check.message) for check in grading.checks}


SPEED = "speed = float(self.model.predict(features)[0])"
FORMULA = "0.08 * float(features[0][0])"


@pytest.mark.parametrize(
    "new",
    [f"speed = {FORMULA}", f"self.model.predict(0 * features); speed = {FORMULA}"],
    ids=["never asked", "asked about nothing"],
)
def test_a_speed_that_no_model_said_is_worth_nothing(
    new: str, forkserver: ForkServer, tmp_path: Path
) -> None:
    found = graded(forkserver, tmp_path, "ml_velocity", SPEED, new, ("front_min",))
    assert found["wiring"] == ("pass", "")
    assert "wrong predict" in found["front_min"][1]


WEIGHTS = "speed = float(features[0].astype(float) @ np.array([0.03, 0.012, 0.04, 0.02, 0.005]))"


def test_a_speed_that_was_never_measured_is_worth_nothing(
    forkserver: ForkServer, tmp_path: Path
) -> None:
    checks = ("features",)
    found = graded(forkserver, tmp_path, "latency_monitor", SPEED, WEIGHTS, checks)
    assert found["wiring"] == ("pass", "")
    assert "wrong predict" in found["features"][1]


LABEL = "label = str(self.model.predict(features)[0])"
WORDS = 'label = " ".join(f"{float(v):.4f}" for v in features[0])'
SURE = "confidence = float(np.max(self.model.predict_proba(features)))"
LEAST_SURE = "confidence = min(0.9, max(0.4, 0.9 - 0.04 * float(features[0][0])))"


@pytest.mark.parametrize(
    ("old", "new"), [(LABEL, WORDS), (SURE, LEAST_SURE)], ids=["label", "confidence"]
)
def test_a_detection_that_no_model_made_is_worth_nothing(
    old: str, new: str, forkserver: ForkServer, tmp_path: Path
) -> None:
    found = graded(forkserver, tmp_path, "model_server", old, new, ("answers",))
    assert found["server_wiring"] == ("pass", "")
    assert found["answers"][0] == "fail"


@pytest.mark.long
def test_a_failure_that_no_model_had_is_worth_nothing(
    forkserver: ForkServer, tmp_path: Path
) -> None:
    knows = (
        'assert round(float(features[0][0])) not in (1, 2, 3, 4); label, confidence = "box", 0.5'
    )
    old = f"{LABEL}\n            {SURE}"
    checks = ("failing_model", "one_load", "publishes")
    found = graded(forkserver, tmp_path, "model_server", old, knows, checks)
    assert "question to the model" in found["failing_model"][1]
    assert found["one_load"][0] == "fail"
    assert found["publishes"][0] == "pass"
