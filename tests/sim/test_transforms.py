"""The frames of the robot: where the lidar is mounted, and what is sent for tf2."""

import math

import msgspec
import numpy as np
import pytest
from simulated import scans_in

from sim.layout import in_frame
from sim.messages import EPOCH_NS, ODOMETRY, TF_MESSAGE, Message, decode, with_epoch
from sim.scenario import LidarSpec, Scenario, Transforms
from sim.scenario_files import scenario_from_toml
from sim.simulation import Simulation

FILE = """
title = "turned"
duration = 0.3
[robot]
start = [0, 0, 30]
[lidar]
mount = [0.1, 0.05, 90]
frame = "rplidar_link"
[transforms]
enabled = true
[world]
[[world.walls]]
points = [[-2, -1], [3, -1], [3, 1.5], [-2, 1.5]]
closed = true
"""
TURNED = scenario_from_toml(FILE, "test")


def run(scenario: Scenario) -> list[Message]:
    return Simulation(scenario).advance(scenario.duration_ns)


def test_a_pose_in_a_frame() -> None:
    x, y, yaw = in_frame((1.0, 2.0, math.pi / 2), (0.5, 0.25, 0.1))
    assert (x, y, yaw) == pytest.approx((0.75, 2.5, math.pi / 2 + 0.1))
    assert in_frame((1.5, -2.5, 0.3), (0.0, 0.0, 0.0)) == (1.5, -2.5, 0.3)


def test_a_mounted_lidar_measures_from_where_it_is() -> None:
    """It sees what a lidar in the middle of a robot sees that stands there."""
    there = in_frame((0.0, 0.0, math.radians(30)), (0.1, 0.05, math.radians(90)))
    stands = msgspec.structs.replace(
        TURNED,
        lidar=LidarSpec(),
        robot=msgspec.structs.replace(
            TURNED.robot, start=(there[0], there[1], math.degrees(there[2]))
        ),
    )
    (mounted, *_), (middle, *_) = scans_in(run(TURNED)), scans_in(run(stands))
    assert mounted.header.frame_id == "rplidar_link"
    assert middle.header.frame_id == "laser"
    np.testing.assert_array_equal(mounted.ranges, middle.ranges)


def test_the_static_transform_comes_once_and_first() -> None:
    messages = run(TURNED)
    assert messages[0].topic == "/tf_static"
    assert [m.topic for m in messages].count("/tf_static") == 1
    (sent,) = decode(messages[0].data, TF_MESSAGE).transforms
    moved = decode(with_epoch(messages[0], EPOCH_NS + 10**9).data, TF_MESSAGE).transforms[0]
    assert moved.header.stamp.sec == sent.header.stamp.sec + 1
    assert moved.transform == sent.transform
    assert (sent.header.frame_id, sent.child_frame_id) == ("base_link", "rplidar_link")
    to, turn = sent.transform.translation, sent.transform.rotation
    assert (to.x, to.y, to.z) == (0.1, 0.05, 0.0)
    assert 2 * math.atan2(turn.z, turn.w) == pytest.approx(math.pi / 2)


def test_a_transform_comes_with_each_odometry() -> None:
    drifting = msgspec.structs.replace(
        TURNED, odometry=msgspec.structs.replace(TURNED.odometry, linear_scale=1.5)
    )
    messages = run(drifting)
    poses = [decode(m.data, ODOMETRY) for m in messages if m.topic == "/odom"]
    sent = [decode(m.data, TF_MESSAGE).transforms[0] for m in messages if m.topic == "/tf"]
    assert len(sent) == len(poses) > 3
    for odometry, found in zip(poses, sent, strict=True):
        assert found.header == odometry.header
        assert found.child_frame_id == odometry.child_frame_id
        assert found.transform.translation.x == odometry.pose.pose.position.x
        assert found.transform.rotation == odometry.pose.pose.orientation


def test_without_them_nothing_else_changes() -> None:
    silent = msgspec.structs.replace(TURNED, transforms=Transforms())
    rest = [m for m in run(TURNED) if not m.topic.startswith("/tf")]
    assert run(silent) == rest


def test_a_bench_counts_from_the_robots_front() -> None:
    bench = """
title = "bench"
duration = 0.1
bench = [{ fill = 5.0, patches = [{ from_deg = 79, to_deg = 81, range = 1.0 }] }]
[world]
[lidar]
mount = [0, 0, -90]
"""
    (scan,) = scans_in(run(scenario_from_toml(bench, "test")))
    (near,) = np.nonzero(scan.ranges == 1.0)
    angles = np.degrees(scan.angle_min + scan.angle_increment * near)
    assert angles.round() == pytest.approx([169, 170, 171])
