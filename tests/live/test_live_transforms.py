"""/tf by the names of REP-105. tf2_msgs has no wheel, so its one message is stood in for."""

import math
from types import SimpleNamespace

import pytest
from geometry_msgs.msg import Transform, TransformStamped

from sim.live.transforms import Transforms
from sim.messages import ODOMETRY, decode, odometry
from sim.scenario import LidarSpec

TRANSFORMS = Transforms(lambda transforms: SimpleNamespace(transforms=transforms), TransformStamped)


def test_odometry_becomes_a_transform_of_the_same_time() -> None:
    sent = decode(odometry(time=5, x=1.5, y=-2.0, yaw=math.pi / 2).data, ODOMETRY)
    (transform,) = TRANSFORMS.of_odometry(sent).transforms
    assert (transform.header.frame_id, transform.child_frame_id) == ("odom", "base_link")
    assert transform.header.stamp == sent.header.stamp
    assert (transform.transform.translation.x, transform.transform.translation.y) == (1.5, -2.0)
    assert transform.transform.rotation.z == pytest.approx(math.sqrt(0.5))
    assert transform.transform.rotation.w == pytest.approx(math.sqrt(0.5))


@pytest.mark.parametrize("x", [math.nan, math.inf])
def test_a_pose_that_is_not_finite_is_no_transform(x: float) -> None:
    sent = decode(odometry(time=5, x=x, y=0.0, yaw=0.0).data, ODOMETRY)
    assert TRANSFORMS.of_odometry(sent) is None


def test_the_laser_sits_in_the_middle_of_the_robot() -> None:
    (transform,) = TRANSFORMS.of_lidar(LidarSpec(), "now").transforms
    assert (transform.header.frame_id, transform.child_frame_id) == ("base_link", "laser")
    assert transform.transform == Transform()
