"""Exercise 8: how a node commands what its model says, right or wrong."""

import struct
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from grader.checks.commands import Answer
from grader.checks.predictions import SpeedInterval
from grader.checks.verdict import CheckFailed
from grader.exercises.model_formats import contract, evidence
from grader.exercises.model_formats.evidence import RIGHT, Habits, as_meant
from grader.exercises.model_formats.habits import driven, habits_of, slip
from grader.host.supplied.probes import Weighted
from grader.link.log import LogLine
from grader.models.features import Floats

WEIGHTS = (0.03, 0.02, 0.05, 0.012, 0.017)
ROWS = [(1.0, 2.0, 0.5, 3.0, 4.0), (2.0, 3.0, 0.2, 1.0, 6.0), (4.0, 4.0, 0.0, 4.0, 4.0)]
EXCHANGED = (0, 1, 2, 4, 3)
NARROW = Habits(narrow=True)


def garbage(speed: float, upper: int = 0) -> float:
    """Return what a double holds whose lower half is an np.float32."""
    number: float = struct.unpack("<d", struct.pack("<fI", speed, upper))[0]
    return number


def recorded(speeds: list[float | None], file: str = "velocity_model.pkl") -> Any:
    """Return the run of a node that commanded these speeds [m/s] after ROWS."""
    node = SimpleNamespace(parameters={"model_path": file})
    scenario = SimpleNamespace(node=node)
    scans = [SimpleNamespace(t=float(i)) for i in range(len(ROWS))]
    return SimpleNamespace(name="run", said=speeds, scenario=scenario, log=(), scans=lambda: scans)


def predicted(order: tuple[int, ...] = contract.ORDER) -> list[float | None]:
    table = np.array(ROWS)[:, order]
    return [float(speed) for speed in Weighted(WEIGHTS, 0.02).predict(table)]


@pytest.fixture(autouse=True)
def three_scans(monkeypatch: pytest.MonkeyPatch) -> None:
    def judged(recording: Any, _tag: str) -> list[Answer]:
        scans: list[Any] = [SimpleNamespace(t=float(i), row=row) for i, row in enumerate(ROWS)]
        return [
            Answer(scan, "3 m", (), 1, speed)
            for scan, speed in zip(scans, recording.said, strict=True)
        ]

    def possible(scan: Any, _front: float) -> Floats:
        return np.array([scan.row])

    monkeypatch.setattr(evidence, "judged", judged)
    monkeypatch.setattr(evidence, "is_predicted", lambda _: False)
    monkeypatch.setattr(evidence, "scan_in_words", lambda *_: "a scan")
    monkeypatch.setattr(contract, "_model", lambda _: Weighted(WEIGHTS, 0.02))
    monkeypatch.setattr("grader.checks.predictions.possible_features", possible)


def test_right_commands_are_right() -> None:
    assert habits_of(recorded(predicted()), recorded(predicted())) == RIGHT
    assert not slip(RIGHT)


def test_two_features_that_change_places_are_found() -> None:
    found = habits_of(recorded(predicted(EXCHANGED)))

    assert found == Habits(order=EXCHANGED)
    assert "if left minimum and right minimum change places" in slip(found)
    evidence.require_speeds(recorded(predicted(EXCHANGED)), habits=found)


@pytest.mark.parametrize("speeds", [[0.0, 0.0, 0.0], [None, None, None], [0.2, 0.3, 0.1]])
def test_commands_that_follow_no_order_have_none(speeds: list[float | None]) -> None:
    assert habits_of(recorded(speeds), recorded(speeds)) == RIGHT


@pytest.mark.parametrize("upper", [0, 0x7FF80000, 0x40091234])
def test_an_np_float32_is_read_as_it_was_meant(upper: int) -> None:
    said = [garbage(speed or 0.0, upper) for speed in predicted()]

    assert habits_of(recorded(predicted()), recorded([*said])) == NARROW
    evidence.require_speeds(recorded([*said]), habits=NARROW)


def test_what_was_meant_may_be_wrong() -> None:
    wrong, right = garbage(0.4), SpeedInterval(0.2, 0.2)
    assert as_meant(wrong, right, NARROW) == wrong
    assert as_meant(garbage(0.2), right, RIGHT) == garbage(0.2)
    assert as_meant(0.2, right, NARROW) == 0.2
    assert as_meant(None, right, NARROW) is None


def test_a_pickle_shows_what_no_onnx_model_does() -> None:
    runs = [recorded([], "./v1.onnx/Model.Pkl"), recorded([], "models.pkl/MODEL.ONNX")]

    assert driven(runs, recorded(predicted()), RIGHT) == runs
    assert driven(runs, recorded([0.0, 0.0, 0.0]), RIGHT) == runs[:1]


@pytest.mark.parametrize(
    ("time", "quoted"), [(-0.5, True), (0.1, False), (1.0, True), (1.9, True), (2.1, False)]
)
def test_the_log_is_quoted_where_it_is_about_the_scan(time: float, quoted: bool) -> None:
    right = predicted()
    run = recorded([right[0], 0.0, right[2]])
    run.log = [LogLine(int(time * 1e9), "error", "not finite")]

    with pytest.raises(CheckFailed) as caught:
        evidence.require_speeds(run, help="Look.")

    said = "The node's log says: not finite" if quoted else "Look."
    assert caught.value.help == said
