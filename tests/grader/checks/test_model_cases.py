"""What a node with a model may command: what its model says, and what it was asked."""

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from grader.checks import model_cases
from grader.checks.case import Runs
from grader.checks.commands import Answer
from grader.checks.model_cases import speed_cases
from grader.checks.model_commands import predicts
from grader.checks.verdict import CheckFailed
from grader.link.log import LogLine
from grader.models.features import Floats
from grader.recording import Inference, Scan
from sim.scenario import Model, NodeSpec

ECHO = Model("echo", {"feature": 0.0, "scale": 0.1})
FRONTS = (1.0, 2.0, 4.0)  # [m] of a scan a second
RIGHT = (0.1, 0.2, 0.4)  # [m/s]
Recorded = Callable[..., Any]


def question(at: float, said: float) -> Inference:
    return Inference("predict", "velocity_model.pkl", int(at * 1e9), int(at * 1e9), 0, (said,))


@pytest.fixture
def recorded(monkeypatch: pytest.MonkeyPatch) -> Recorded:
    """Return the run of a node that commanded these speeds and asked its model."""

    def possible(scan: Any, _front: float = 60.0) -> Floats:
        return np.array([[scan.front, 1.0, 1.0, 1.0, 1.0]])

    def of(speeds: tuple[float, ...], asked: tuple[float, ...] = RIGHT, **node: Any) -> Any:
        found = [
            Answer(
                cast("Scan", SimpleNamespace(t=i, front=front)),
                f"{front} m",
                (),
                count=1,
                twist={"linear.x": speed},
            )
            for i, (front, speed) in enumerate(zip(FRONTS, speeds, strict=True))
        ]
        monkeypatch.setattr(model_cases, "answers", lambda _: found)
        node = {"parameters": {}, "models": {"velocity_model.pkl": ECHO}, **node}
        scenario = SimpleNamespace(
            node=NodeSpec(**node), faults=SimpleNamespace(scan_loss=0.0), bench_scans=found
        )
        return SimpleNamespace(
            name="run",
            scenario=scenario,
            log=[],
            slack=0.0,
            duration_s=3.0,
            inferences=[question(i + 0.01, said) for i, said in enumerate(asked)],
            outcome=SimpleNamespace(completed=True),
            times=lambda _: np.arange(3.0),
        )

    monkeypatch.setattr("grader.checks.predictions.possible_features", possible)
    monkeypatch.setattr(model_cases, "possible_features", possible)
    monkeypatch.setattr("grader.checks.words.require_alive", lambda _: None)
    return of


def judge(run: Any, help: str = "") -> None:
    predicts(Runs([run], lambda run: speed_cases(run, ECHO)), help=help)


def wrong(run: Any) -> list[str]:
    return [case.wrong(1e-3) for case in speed_cases(run, ECHO)]


def test_what_the_model_says_is_right(recorded: Recorded) -> None:
    assert wrong(recorded(RIGHT)) == ["", "", ""]
    assert wrong(recorded((0.1, 0.2, 0.3))) == ["", "", "linear.x"]
    assert wrong(recorded((0.0,) * 3, (), parameters={"max_speed": 0.0})) == [""] * 3
    judge(recorded(RIGHT))


@pytest.mark.parametrize(
    ("time", "quoted"), [(-0.5, True), (0.9, False), (1.0, True), (1.9, True), (2.1, False)]
)
def test_the_log_is_quoted_where_it_is_about_the_scan(
    recorded: Recorded, time: float, quoted: bool
) -> None:
    run = recorded((0.1, 0.0, 0.4))
    run.log = [LogLine(int(time * 1e9), "error", "not finite")]

    with pytest.raises(CheckFailed) as caught:
        judge(run, "Look.")

    assert caught.value.help == ("The node's log says: not finite" if quoted else "Look.")


def test_a_rounded_prediction_is_named(recorded: Recorded) -> None:
    with pytest.raises(CheckFailed, match="wrong linear") as caught:
        judge(recorded((0.1, 0.204, 0.4)))
    assert "rounded" in caught.value.help
    assert caught.value.actual == "linear.x = 0.204 m/s"
