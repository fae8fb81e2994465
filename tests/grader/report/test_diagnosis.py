"""What `course doctor` says of a machine."""

import io
import re
from dataclasses import replace

import msgspec
import pytest
from click.testing import CliRunner
from rich.console import Console

from grader.cli import cli
from grader.course.exercises import all_exercises
from grader.grading.trying import imports_that_fail, why_none_runs
from grader.report import diagnosis
from grader.report.diagnosis import render_diagnosis
from rclpy_virtual_time.host.sandbox.layers import LAYERS, LIMITS
from rclpy_virtual_time.link.doctor import Diagnosis, Layer


def said_of(found: Diagnosis) -> str:
    console = Console(file=io.StringIO(), width=100)
    render_diagnosis(found, console)
    text: str = console.file.getvalue()  # type: ignore[attr-defined]
    return " ".join(text.split())


def machine(problem: str = "", layers: tuple[str, ...] = LAYERS) -> Diagnosis:
    return Diagnosis(
        python="3.12",
        ros="wheels",
        problem=problem,
        layers=tuple(Layer(name, name in layers) for name in LAYERS),
    )


def test_nodes_run_here() -> None:
    assert why_none_runs() == ""


def test_the_page_names_what_is_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(diagnosis, "EXTRAS", {"clusters": ("no-such-thing",), "models": ()})
    said = said_of(machine(layers=(LIMITS,)))

    assert re.search(r"missing +clusters: no-such-thing", said)
    assert "needs Landlock: Linux 5.13 or later" in said
    assert "Your own code only" in said and "--trust" in said
    assert "Other people's code may be graded here." in said_of(machine())
    open_ = said_of(replace(machine(), gaps=("Landlock 1 lets files be emptied",)))
    assert "What a submission can still do here" in open_ and "lets files be emptied" in open_


@pytest.mark.parametrize(
    ("found", "tried", "code"),
    [
        (machine(), "", 0),
        (machine(layers=(LIMITS,)), "", 1),
        (machine("no ROS 2"), "", 2),
        (machine(), "no ROS 2", 2),  # what trying to grade a skeleton says
    ],
)
def test_the_exit_code(
    found: Diagnosis, tried: str, code: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Diagnosis, "of_this_machine", lambda: found)
    monkeypatch.setattr("grader.grading.trying.why_none_runs", lambda: tried)
    monkeypatch.setattr("grader.grading.trying.imports_that_fail", lambda: ["no torch"])
    result = CliRunner().invoke(cli, ["doctor"], standalone_mode=False)

    assert result.return_value == code
    assert ("No node can run here: no ROS 2" in result.output) == (code == 2)
    assert ("no torch" in result.output) == (code != 2)


def test_what_an_exercise_imports_is_tried(monkeypatch: pytest.MonkeyPatch) -> None:
    libraries = ("sklearn.tree", "sklearn.no_such")
    exercise = msgspec.structs.replace(all_exercises()[0], libraries=libraries)
    monkeypatch.setattr("grader.grading.trying.all_exercises", lambda: [exercise])

    (said,) = imports_that_fail()

    assert "No module named 'sklearn.no_such'" in said
