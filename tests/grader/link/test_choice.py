"""Which launcher a command takes."""

from __future__ import annotations

import pytest

from grader.launchers import why_no_class
from rclpy_virtual_time import NoRos, PracticeServer, RosEnvironment
from rclpy_virtual_time.link import practice


def no_ros() -> None:
    raise NoRos("ROS 2 Jazzy was not found")


def test_linux_with_ros_takes_the_real_one() -> None:
    assert PracticeServer.why_needed() == ""
    assert why_no_class(trust=False) == ""


def test_without_ros_a_class_needs_trust(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(RosEnvironment, "find", no_ros)
    assert PracticeServer.why_needed() == "ROS 2 Jazzy was not found"
    refusal = why_no_class(trust=False)
    assert "for practice only" in refusal and "--trust" in refusal
    assert why_no_class(trust=True) == ""


def test_without_fork_no_class_is_graded(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delattr(practice.os, "fork")
    assert "is for Linux" in PracticeServer.why_needed()
    assert why_no_class(trust=True).startswith("course autograde needs Linux")
