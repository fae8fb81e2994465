"""The lesson's programs keep its rules: what says nothing, or is old, means zero."""

import math
import runpy
import tempfile
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
import rclpy
from geometry_msgs.msg import TransformStamped
from lesson_pages import LESSONS, PAGES, blocks
from nav_msgs.msg import Odometry
from sensor_msgs.msg import LaserScan

from rclpy_virtual_time.host import stand_ins

NODES = LESSONS / "pitfalls" / "nodes"
BLIND = {
    "nan": [math.nan] * 360,
    "beyond": [50.0] * 360,
    "zero": [0.0] * 360,  # as an LDS-01 has it
    "empty": [],
    "too near": [-math.inf] * 360,
}
FREE = {"far": [math.inf] * 360, "open": [8.0] * 360}


@pytest.fixture(scope="module", autouse=True)
def ros() -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patched:
        patched.syspath_prepend(str(stand_ins.FOLDER))
        rclpy.init()
        yield
        rclpy.shutdown()


def made(name: str, kind: str, publisher: str) -> tuple[Any, list[Any]]:
    """Return a node of a listing, and the list of what it publishes."""
    file = NODES / name
    with tempfile.TemporaryDirectory() as folder:
        if not file.exists():
            file = Path(folder, name)
            listed = (block for page in PAGES for block in blocks(page))
            file.write_text(next(b.text for b in listed if b.options.get("caption") == name))
        node, said = runpy.run_path(str(file))[kind](), []
    setattr(node, publisher, SimpleNamespace(publish=said.append))
    return node, said


def scan(node: Any, ranges: list[float]) -> LaserScan:
    message = LaserScan(angle_min=-math.pi, angle_increment=math.tau / 360, ranges=ranges)
    message.range_min, message.range_max = 0.15, 12.0
    message.header.frame_id = "laser"
    message.header.stamp = node.get_clock().now().to_msg()
    return message


@pytest.mark.parametrize(
    ("name", "kind", "publisher", "callback"),
    [
        ("wander.py", "Wander", "cmd_vel", "on_scan"),
        ("eyes.py", "Eyes", "nearest", "on_scan"),
        ("wall_stop_right.py", "WallStop", "publisher", "scan_callback"),
    ],
)
def test_blind_is_zero_and_free_is_not(name: str, kind: str, publisher: str, callback: str) -> None:
    node, said = made(name, kind, publisher)
    for ranges in (*BLIND.values(), *FREE.values()):
        getattr(node, callback)(scan(node, ranges))
    spoken = [each.data if hasattr(each, "data") else each.linear.x for each in said]
    free = spoken[-len(FREE) :]
    assert set(spoken[: -len(FREE)]) == {0.0} and min(free) > 0.3


def test_a_lidar_that_looks_backwards_and_does_not_see_ahead_is_blind() -> None:
    node, said = made("mounted_agent.py", "MountedAgent", "cmd_vel")
    for z, w in ((1.0, 0.0), (0.0, 1.0)):  # backwards, ahead
        mount = TransformStamped()
        mount.header.frame_id, mount.child_frame_id = "base_link", "laser"
        mount.transform.rotation.z, mount.transform.rotation.w = z, w
        node.frames.set_transform_static(mount, "test")
        seen = scan(node, [3.0] * 1080)
        seen.angle_min, seen.angle_increment = math.radians(-135), math.radians(270) / 1080
        node.on_scan(seen)
    assert [each.linear.x for each in said] == [0.0, 0.4]


@pytest.mark.parametrize(
    ("name", "kind", "publisher", "callbacks"),
    [
        ("errand.py", "Errand", "cmd_vel", ("on_odometry", "control")),
        (
            "heading_without_yaw_right.py",
            "PointSeeker",
            "publisher",
            ("odom_callback", "control_callback"),
        ),
    ],
)
def test_an_old_pose_is_none(
    name: str, kind: str, publisher: str, callbacks: tuple[str, str]
) -> None:
    node, said = made(name, kind, publisher)
    for age in (1, 0):  # [s]
        odometry = Odometry()
        odometry.pose.pose.orientation.w = 1.0
        odometry.header.stamp = node.get_clock().now().to_msg()
        odometry.header.stamp.sec -= age
        getattr(node, callbacks[0])(odometry)
        getattr(node, callbacks[1])()
    still, drives = ((each.linear.x, each.angular.z) for each in said)
    assert still == (0.0, 0.0) and drives[0] > 0.1


def test_an_old_scan_is_none() -> None:
    node, said = made("computing_callback_right.py", "CarefulDriver", "publisher")
    for age in (1, 0):  # [s]
        seen = scan(node, [8.0] * 360)
        seen.header.stamp.sec -= age
        node.scan, node.said = seen, (0.5, seen)
        node.control_callback()
    assert [each.linear.x for each in said] == [0.0, 0.5]


@pytest.mark.parametrize(
    ("name", "kind", "publisher"),
    [("gate.py", "Gate", "cmd_vel"), ("no_latch_right.py", "StopGate", "publisher")],
)
def test_a_gate_begins_stopped(name: str, kind: str, publisher: str) -> None:
    node, _ = made(name, kind, publisher)
    assert node.stopped
