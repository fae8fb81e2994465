"""Libraries that are not installed: said of the judge's own installation, played for a node."""

import importlib.machinery
import importlib.util
from pathlib import Path

import msgspec
import pytest

from grader.course.installed import why_not
from grader.errors import GraderError
from grader.trial.trials import SavedTrials
from sim.scenario import NodeSpec, ProgramSpec, Scenario


def test_it_says_what_is_missing_and_what_to_do(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    assert why_not(()) == ""
    assert why_not(("torch",)) == "skipped: PyTorch is not installed here; pip install torch"
    assert why_not(("sklearn", "keras")) == (
        "skipped: scikit-learn and Keras are not installed here; pip install scikit-learn keras"
    )


def test_a_folder_of_that_name_is_no_library(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    def find_spec(name: str) -> importlib.machinery.ModuleSpec | None:
        return importlib.machinery.PathFinder.find_spec(name, [str(tmp_path)])

    (tmp_path / "torch").mkdir()
    monkeypatch.setattr(importlib.util, "find_spec", find_spec)
    assert "PyTorch" in why_not(("torch",))


def test_a_library_that_nobody_knows() -> None:
    with pytest.raises(GraderError, match="'tensorflow'; there are: sklearn"):
        why_not(("tensorflow",))


def test_what_was_recorded_needs_no_library_any_more(
    run_node, monkeypatch: pytest.MonkeyPatch
) -> None:
    trials = SavedTrials([run_node("")])  # of demo_wall
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    assert trials.lacks(("demo_wall",), ("torch",)) == ""
    assert "PyTorch" in trials.lacks(("demo_wall", "demo_open"), ("torch",))


IMPORTS = """
import importlib.util
print('found:', importlib.util.find_spec('colorsys'), importlib.util.find_spec('numpy') is not None)
try:
    import colorsys
except ImportError as error:
    print(f'{type(error).__name__}: {error}')
try:
    from xml.dom import minidom
except ImportError as error:
    print(f'{type(error).__name__}: {error}')
rclpy.init()
rclpy.spin(Echo())
"""


def test_hidden_libraries_seem_not_installed(run_node, short_scenario: Scenario) -> None:
    node = NodeSpec(hides=("colorsys", "xml"))
    recording = run_node(IMPORTS, msgspec.structs.replace(short_scenario, node=node))
    assert [line.text for line in recording.log][:3] == [
        "found: None True",
        "ModuleNotFoundError: No module named 'colorsys'",
        "ModuleNotFoundError: No module named 'xml'",
    ]
    assert recording.outcome.completed
    assert len(recording.twists().t)


def test_several_programs_can_hide_libraries(run_node, short_scenario: Scenario) -> None:
    several = msgspec.structs.replace(
        short_scenario,
        node=NodeSpec(hides=("colorsys", "xml")),
        program=(ProgramSpec(), ProgramSpec("model_swap.py", supplied=True, start=1e3)),
    )
    recording = run_node(IMPORTS, several)  # a program without a file is the one that is graded
    assert recording.outcome.completed
    assert "ModuleNotFoundError: No module named 'colorsys'" in [x.text for x in recording.log]
