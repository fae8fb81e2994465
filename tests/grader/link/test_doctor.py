"""What `course doctor` says of a machine."""

import functools
import io
import re

import msgspec
import pytest
from click.testing import CliRunner
from rich.console import Console

from grader.cli import cli
from grader.course.exercises import all_exercises
from grader.grading.trying import imports_that_fail, why_none_runs
from grader.report import diagnosis
from grader.report.diagnosis import render_diagnosis
from rclpy_virtual_time.host.frames import Hello
from rclpy_virtual_time.host.sandbox.layers import CALLS, FILES, LAYERS, LIMITS, USER
from rclpy_virtual_time.link import doctor
from rclpy_virtual_time.link.doctor import Diagnosis, Layer, gaps


def test_this_machine_can_run_nodes() -> None:
    found = Diagnosis.of_this_machine()

    assert (found.problem, why_none_runs()) == ("", "")
    assert found.ros
    assert tuple(layer.name for layer in found.layers) == LAYERS
    assert found.layers[0] == Layer(LIMITS, True)
    assert all(layer.text.startswith(("keeps out: ", "needs ")) for layer in found.layers)


@pytest.mark.parametrize(
    ("layers", "allowed"),
    [(LAYERS, True), ((LIMITS, FILES), True), ((LIMITS, USER, CALLS), False), ((LIMITS,), False)],
)
def test_foreign_code_needs_a_wall_around_files(layers: tuple[str, ...], allowed: bool) -> None:
    assert (machine(layers=layers).foreign_code == "") == allowed


WORDS = {  # taken away: what is said of it
    "": (),
    "mounts": ("the disk of", "fill /dev/shm"),
    "files": ("read solutions",),
    "calls": ("start programs and processes",),
    "user": ("run as root",),
    "network": ("datagrams",),
    "calls network": ("talk to the network",),
}


@pytest.mark.parametrize("off", WORDS)
def test_what_is_open_is_said_in_plain_words(off: str) -> None:
    there = tuple(layer for layer in LAYERS if layer not in off.split())
    said = " ".join(gaps(Hello(there, landlock=6, counted=True), root=True))

    assert all(words in said for words in WORDS[off])
    assert bool(said) == bool(off)


@pytest.mark.parametrize(
    ("abi", "filtered", "said"), [(2, False, True), (2, True, False), (3, False, False)]
)
def test_an_old_landlock_and_uncounted_threads_are_said(
    abi: int, filtered: bool, said: bool
) -> None:
    there = [layer for layer in LAYERS if filtered or layer != CALLS]
    text = " ".join(gaps(Hello(tuple(there), landlock=abi), root=True))

    assert (f"Landlock {abi} lets files be emptied" in text) == said
    assert "does not count a submission's threads" in text


def test_a_fork_server_with_less_is_diagnosed(monkeypatch: pytest.MonkeyPatch) -> None:
    """Not only made-up means: hosts that really lack layers say so."""
    less = functools.partial(doctor.ForkServer, layers=(LIMITS, FILES), landlock=1)
    monkeypatch.setattr(doctor, "ForkServer", less)
    found = Diagnosis.of_this_machine()

    here = {layer.name: layer for layer in found.layers if layer.here}
    if FILES not in here:
        pytest.skip("no Landlock on this machine")
    assert set(here) == {LIMITS, FILES}
    assert here[FILES].text.endswith("(Landlock ABI 1)")
    assert "Landlock 1 lets files be emptied" in said_of(found)
    assert "What a submission can still do here" in said_of(found)


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


def test_the_page_names_what_is_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(diagnosis, "EXTRAS", {"clusters": ("no-such-thing",), "models": ()})
    said = said_of(machine(layers=(LIMITS,)))

    assert re.search(r"missing +clusters: no-such-thing", said)
    assert "needs Landlock: Linux 5.13 or later" in said
    assert "Your own code only" in said and "--trust" in said
    assert "Other people's code may be graded here." in said_of(machine())


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
