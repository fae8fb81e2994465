"""What is said of a computer: whether there are wheels of ROS for it, and who has tried it."""

import platform
import sys
from io import StringIO

import pytest
from rich.console import Console

from grader.course.installed import never_run
from grader.report.diagnosis import render_practice
from rclpy_virtual_time.link import system
from rclpy_virtual_time.link.errors import NoRos
from rclpy_virtual_time.link.ros_environment import RosEnvironment

TRIED = ("linux", "x86_64")
UNTRIED = [("darwin", "arm64"), ("darwin", "x86_64"), ("win32", "AMD64"), ("linux", "aarch64")]


def be(monkeypatch: pytest.MonkeyPatch, name: str, machine: str) -> None:
    monkeypatch.setattr(sys, "platform", name)
    monkeypatch.setattr(platform, "machine", lambda: machine)


@pytest.mark.parametrize("found", UNTRIED, ids="-".join)
def test_where_nobody_has_run_it_the_doctor_says_so(
    monkeypatch: pytest.MonkeyPatch, found: tuple[str, str]
) -> None:
    be(monkeypatch, *found)
    said = StringIO()
    render_practice("the reason", Console(file=said, width=400))
    assert "has never been run on" in said.getvalue()
    assert not system.has_ros_wheels()


@pytest.mark.parametrize("version", [(3, 14), (3, 15)])
@pytest.mark.parametrize("found", [TRIED, *UNTRIED], ids="-".join)
def test_nobody_is_asked_to_install_wheels_that_there_are_none_of(
    monkeypatch: pytest.MonkeyPatch, found: tuple[str, str], version: tuple[int, int]
) -> None:
    be(monkeypatch, *found)
    monkeypatch.setattr(sys, "version_info", version)
    with pytest.raises(NoRos) as error:
        RosEnvironment.find({}, ())
    there_are = found == TRIED and version < (3, 15)
    assert (never_run() == "") == (found == TRIED)
    assert system.has_ros_wheels() == there_are
    assert ("pip install" in str(error.value)) == there_are
    assert ("no wheels of it" in str(error.value)) != there_are
