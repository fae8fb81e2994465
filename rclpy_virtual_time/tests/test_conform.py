"""The command that compares virtual time with time: what it finds, and what it makes of it."""

import tempfile
from pathlib import Path

import pytest

from rclpy_virtual_time.conform import places, suites
from rclpy_virtual_time.conform.__main__ import main
from rclpy_virtual_time.conform.review import (
    LIST,
    Difference,
    Entry,
    Reviewed,
    differences,
    read_list,
    review,
)
from rclpy_virtual_time.host.frames import ProgramStart
from rclpy_virtual_time.link.errors import EngineError
from rclpy_virtual_time.link.hosts import ForkServer

TESTS = """
import os, threading, time
def test_same(): time.sleep(0.01)
def test_other(): assert time.time() > 1.75e9  # a host's time begins in 2023
def test_dies(): os._exit(3)
def test_after(): assert threading.current_thread() is threading.main_thread()
"""


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    """Something like a checkout of rclpy."""
    tests = tmp_path / "rclpy" / "test"
    tests.mkdir(parents=True)
    (tests / "test_few.py").write_text(TESTS)
    return tmp_path


def test_each_test_is_run_in_both_places(checkout: Path, forkserver: ForkServer) -> None:
    assert suites.rclpy_modules(checkout) == ["test/test_few.py"]
    plain, inside = suites.run_module("rclpy", "test/test_few.py", forkserver, checkout)
    assert list(plain.outcomes.items()) == [
        ("test/test_few.py::test_same", "passed"),
        ("test/test_few.py::test_other", "passed"),
        ("test/test_few.py::test_dies", "exited"),
        ("test/test_few.py::test_after", "passed"),
    ]
    assert inside.outcomes == plain.outcomes | {
        "test/test_few.py::test_other": "failed",
        "test/test_few.py::test_dies": "died",
    }
    assert "1.75" in inside.texts["test/test_few.py::test_other"]


@pytest.mark.parametrize(
    "source, kind",
    [
        ("import threading; threading.Event().wait()", "stuck"),
        ("import time\nwhile True: time.sleep(0.5)", "time"),
    ],
)
def test_a_wait_without_end_is_said(source: str, kind: str, forkserver: ForkServer) -> None:
    with tempfile.TemporaryDirectory() as name:  # not tmp_path, which is closed to a host
        program = Path(name) / "waits.py"
        program.write_text(source)
        ran = places.run_inside(forkserver, Path(name), ProgramStart(str(program)), 5)
    assert ran.kind == kind


def test_nothing_of_it_has_rights_over_the_machine(tmp_path: Path, forkserver: ForkServer) -> None:
    program = tmp_path / "rights.py"
    program.write_text("print(*[s for s in open('/proc/self/status') if s.startswith('Cap')])")
    ran = places.run_plain(forkserver, tmp_path, [str(program)])
    rights = dict(line.split() for line in ran.said.splitlines() if line.strip())
    assert {int(rights[kind], 16) for kind in ("CapPrm:", "CapEff:")} == {0}


ENTRY = Entry(("a1", "b"), "because")


def test_a_listed_difference_is_meant_and_another_is_not() -> None:
    found = differences(
        {"a1": "passed", "a2": "passed", "b": "passed", "c": "passed", "d": "passed"},
        {"a1": "failed", "a2": "passed", "b": "failed", "c": "failed"},
        {"c": "why"},
    )
    assert found == [
        Difference("a1", "passed", "failed"),
        Difference("b", "passed", "failed"),
        Difference("c", "passed", "failed", "why"),
        Difference("d", "passed", "absent"),
    ]
    result = review(found, "abcd", Reviewed(meant=(ENTRY,)))
    assert [difference.test for difference, _ in result.meant] == ["a1", "b"]
    assert result.unlisted == found[2:]
    assert not result.passed
    assert review(found[:2], "ab", Reviewed(meant=(ENTRY,))).passed


def test_a_listed_difference_has_to_be_of_the_listed_kind() -> None:
    hangs = Difference("b", "passed", "hung")
    assert review([hangs], ["b"], Reviewed(meant=(ENTRY,))).unlisted == [hangs]


def test_what_no_longer_differs_must_leave_the_list() -> None:
    result = review([Difference("b", "passed", "failed")], ["a1", "b"], Reviewed(meant=(ENTRY,)))
    assert result.stale == ["a1"]
    assert not result.passed
    assert review([], ["c"], Reviewed(meant=(ENTRY,))).passed  # they have not been run


def test_what_fails_in_plain_python_only_is_named_and_needs_no_entry() -> None:
    result = review([Difference("c", "failed", "passed")], ["c"], Reviewed())
    assert (result.late, result.unlisted, result.passed) == (["c"], [], True)
    assert not review([Difference("c", "failed", "hung")], ["c"], Reviewed()).passed


@pytest.mark.parametrize("suite", ["rclpy", "cpython"])
def test_the_list_gives_each_reason(suite: str) -> None:
    reviewed = read_list(suite)
    assert reviewed.meant
    for entry in reviewed.meant:
        assert len(entry.reason) > 20, entry
        assert entry.tests, entry
    tests = [test for entry in reviewed.meant for test in entry.tests]
    assert len(tests) == len(set(tests))
    assert not any("*" in test for test in tests)


def test_a_list_of_another_form_is_refused(tmp_path: Path) -> None:
    wrong = tmp_path / LIST.name
    wrong.write_text('[[rclpy.meant]]\ntests = ["a"]\n')
    with pytest.raises(EngineError, match="reason"):
        read_list("rclpy", wrong)


def test_a_folder_without_rclpy_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["rclpy", str(tmp_path)]) == 2
    assert "expected a checkout of ros2/rclpy" in capsys.readouterr().err
