"""Which launcher a command takes."""

from __future__ import annotations

import pytest

from grader.launchers import why_no_class
from rclpy_virtual_time.link import choice
from rclpy_virtual_time.link.errors import NoRos


def no_ros() -> None:
    raise NoRos("ROS 2 Jazzy was not found")


def test_linux_with_ros_takes_the_real_one() -> None:
    assert choice.why_not_linux() == ""
    assert why_no_class(trust=False) == ""


def test_without_ros_a_class_needs_trust(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(choice, "find_ros", no_ros)
    assert choice.why_not_linux() == "ROS 2 Jazzy was not found"
    refusal = why_no_class(trust=False)
    assert "for practice only" in refusal and "--trust" in refusal
    assert why_no_class(trust=True) == ""


def test_without_fork_no_class_is_graded(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delattr(choice.os, "fork")
    assert "is for Linux" in choice.why_not_linux()
    assert why_no_class(trust=True).startswith("course autograde needs Linux")
