"""RViz shows what the robot sends: topics, frames and QoS are the robot's."""

from __future__ import annotations

from typing import Any

import pytest
import yaml

from grader.course.exercises import ROOT
from sim.messages import GOAL_TOPIC, ODOM_FRAME, ODOM_TOPIC, SCAN_TOPIC

FILE = ROOT / "exercises" / "rviz" / "course.rviz"


@pytest.fixture(scope="module")
def manager() -> dict[str, Any]:
    found: dict[str, Any] = yaml.safe_load(FILE.read_text("utf-8"))["Visualization Manager"]
    return found


def by_class(listed: list[dict[str, Any]]) -> dict[str, dict[str, Any]]:
    return {each["Class"].removeprefix("rviz_default_plugins/"): each for each in listed}


def test_everything_the_robot_says_is_shown(manager: dict[str, Any]) -> None:
    displays = by_class(manager["Displays"])
    assert set(displays) == {"Grid", "TF", "LaserScan", "Odometry", "Pose"}
    assert all(display["Enabled"] for display in displays.values())
    topics = {name: d["Topic"]["Value"] for name, d in displays.items() if "Topic" in d}
    assert topics == {"LaserScan": SCAN_TOPIC, "Odometry": ODOM_TOPIC, "Pose": GOAL_TOPIC}


def test_the_floor_stands_still(manager: dict[str, Any]) -> None:
    assert manager["Global Options"]["Fixed Frame"] == ODOM_FRAME


def test_best_effort_hears_reliable_drivers_too(manager: dict[str, Any]) -> None:
    for name in ("LaserScan", "Odometry", "Pose"):
        topic = by_class(manager["Displays"])[name]["Topic"]
        assert topic["Reliability Policy"] == "Best Effort", name
        assert topic["Durability Policy"] == "Volatile", name
        assert topic["History Policy"] == "Keep Last", name


def test_a_click_sends_a_goal(manager: dict[str, Any]) -> None:
    tools = by_class(manager["Tools"])
    assert tools["SetGoal"]["Topic"]["Value"] == GOAL_TOPIC
    assert tools["SetGoal"]["Topic"]["Reliability Policy"] == "Reliable"
