"""tf2_msgs and tf2_ros for programs of ours: as on a robot, though pip has no package of them."""

import importlib
import math
import sys
from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any

import pytest
import yaml
from geometry_msgs.msg import Point, PointStamped, PoseWithCovarianceStamped, TransformStamped
from rclpy.clock_type import ClockType
from rclpy.duration import Duration
from rclpy.serialization import deserialize_message, serialize_message
from rclpy.time import Time
from rosbags.typesys import Stores, get_typestore
from std_msgs.msg import Header

from rclpy_virtual_time.host import stand_ins
from rclpy_virtual_time.host.interfaces import native

TF_MESSAGE = "tf2_msgs/msg/TFMessage"
SECOND = 10**9  # [ns]


@pytest.fixture(scope="module")
def packages() -> Iterator[Any]:
    """The stand-ins, imported here for once; no other test sees them."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys, "path", [str(stand_ins.FOLDER), *sys.path])
        yield SimpleNamespace(
            tf2_ros=importlib.import_module("tf2_ros"),
            msg=importlib.import_module("tf2_msgs.msg"),
            geometry=importlib.import_module("tf2_geometry_msgs"),
        )
        for name in [n for n in sys.modules if n.partition(".")[0] in stand_ins.NAMES]:
            del sys.modules[name]


def transform(
    parent: str, child: str, x: float = 0.0, yaw: float = 0.0, at: float = 0.0
) -> TransformStamped:
    found = TransformStamped()
    found.header.stamp = Time(nanoseconds=round(at * SECOND)).to_msg()
    found.header.frame_id, found.child_frame_id = parent, child
    found.transform.translation.x = x
    found.transform.rotation.z, found.transform.rotation.w = math.sin(yaw / 2), math.cos(yaw / 2)
    return found


def x_y_yaw(found: TransformStamped) -> tuple[float, float, float]:
    to, turn = found.transform.translation, found.transform.rotation
    return to.x, to.y, 2 * math.atan2(turn.z, turn.w)


# --- TFMessage ------------------------------------------------------------------------------------


@pytest.mark.parametrize("frames", [[], ["laser"], ["laser", "a", "imu_link", "", "camera_link"]])
def test_a_message_has_the_bytes_of_the_real_one(packages: Any, frames: list[str]) -> None:
    """Nor do they pile up: what C allocates for a message goes with it."""
    transforms = [
        transform("base_link", name, x=float(i), yaw=0.1 * i) for i, name in enumerate(frames)
    ]
    message = packages.msg.TFMessage(transforms=transforms)
    data = serialize_message(message)
    rosbags = get_typestore(Stores.ROS2_JAZZY)  # it has the real definition
    theirs = rosbags.deserialize_cdr(data, TF_MESSAGE)
    assert [each.child_frame_id for each in theirs.transforms] == frames
    assert (
        deserialize_message(
            bytes(rosbags.serialize_cdr(theirs, TF_MESSAGE)), packages.msg.TFMessage
        )
        == message
    )
    assert not native._alive


# --- the buffer -----------------------------------------------------------------------------------


def buffer_with(packages: Any, *transforms: TransformStamped, static: bool = False) -> Any:
    buffer = packages.tf2_ros.Buffer()
    for each in transforms:
        (buffer.set_transform_static if static else buffer.set_transform)(each, "test")
    return buffer


def test_transforms_are_composed_and_inverted(packages: Any) -> None:
    buffer = buffer_with(
        packages,
        transform("odom", "base_link", x=2.0, yaw=math.pi / 2),
        transform("base_link", "laser", x=0.5, yaw=math.pi),
        transform("base_link", "imu", x=1.5, yaw=math.pi),
        static=True,
    )
    sibling = buffer.lookup_transform("imu", "laser", Time())
    assert x_y_yaw(sibling) == pytest.approx((1.0, 0.0, 0.0))
    there = buffer.lookup_transform("odom", "laser", Time())
    assert x_y_yaw(there) == pytest.approx((2.0, 0.5, 3 * math.pi / 2))
    assert (there.header.frame_id, there.child_frame_id) == ("odom", "laser")
    back = x_y_yaw(buffer.lookup_transform("laser", "odom", Time()))
    assert back[:2] == pytest.approx((0.5, -2.0))
    assert math.remainder(back[2] - math.pi / 2, math.tau) == pytest.approx(0.0)
    assert x_y_yaw(buffer.lookup_transform("laser", "laser", Time())) == (0.0, 0.0, 0.0)
    assert buffer._getFrameStrings() == ["odom", "base_link", "laser", "imu"]
    assert (buffer._frameExists("/odom"), buffer._frameExists("map")) == (True, False)
    assert isinstance(buffer, packages.tf2_ros.BufferInterface)


def test_between_two_stamps_it_interpolates(packages: Any) -> None:
    buffer = buffer_with(
        packages,
        transform("odom", "base", x=1.0, yaw=3.0, at=1.0),
        transform("odom", "base", x=2.0, yaw=-3.0, at=2.0),
    )
    quarter = buffer.lookup_transform("odom", "base", Time(nanoseconds=SECOND + SECOND // 4))
    turn = (math.tau - 6.0) / 4  # the short way
    assert x_y_yaw(quarter) == pytest.approx((1.25, 0.0, 3.0 + turn))
    newest = buffer.lookup_transform("odom", "base", Time())
    assert x_y_yaw(newest)[0] == 2.0
    assert newest.header.stamp.sec == 2


def test_what_can_not_be_had_raises_as_in_tf2(packages: Any) -> None:
    tf2 = packages.tf2_ros
    buffer = buffer_with(
        packages,
        transform("odom", "base", at=1.0),
        transform("odom", "base", at=2.0),
        transform("map", "other"),
    )
    late = "the latest data is at time 2.000000, when looking up transform from frame [base] to"
    for target, source, when, error, said in [
        ("odom", "nobody", 0, tf2.LookupException, '"nobody" passed to lookupTransform argument s'),
        ("no", "where", 0, tf2.LookupException, '"no" passed to lookupTransform argument target_'),
        ("odom", "other", 0, tf2.ConnectivityException, "not part of the same tree"),
        ("odom", "base", SECOND // 2, tf2.ExtrapolationException, "past.  Requested time 0.500000"),
        ("odom", "base", 3 * SECOND, tf2.ExtrapolationException, late),
    ]:
        with pytest.raises(error):
            buffer.lookup_transform(target, source, Time(nanoseconds=when))
        assert issubclass(error, tf2.TransformException)
        can, why = buffer.can_transform(
            target, source, Time(nanoseconds=when), return_debug_tuple=True
        )
        assert not can
        assert said in why
    ring = buffer_with(packages, transform("a", "b"), transform("b", "a"), static=True)
    with pytest.raises(tf2.LookupException, match="loop"):
        ring.lookup_transform("a", "b", Time())
    short = tf2.Buffer(cache_time=Duration(seconds=1))
    for at in (1.0, 2.0, 4.0):
        short.set_transform(transform("odom", "base", at=at), "test")
    assert not short.can_transform("odom", "base", Time(nanoseconds=2 * SECOND))  # it is too old
    for bad in (transform("odom", "odom"), transform("", "base"), transform("a", "b", x=math.nan)):
        with pytest.raises(tf2.InvalidArgumentException):
            buffer.set_transform(bad, "test")


def test_a_lookup_may_go_through_a_fixed_frame_and_two_times(packages: Any) -> None:
    buffer = buffer_with(
        packages, transform("odom", "base", x=1.0, at=1.0), transform("odom", "base", x=4.0, at=2.0)
    )
    ends = "base", Time(seconds=2), "base", Time(seconds=1).to_msg(), "odom"
    assert buffer.can_transform_full(*ends)
    assert x_y_yaw(buffer.lookup_transform_full(*ends))[0] == pytest.approx(-3.0)
    assert yaml.safe_load(buffer.all_frames_as_yaml())["base"]["parent"] == "odom"
    assert buffer.get_latest_common_time("odom", "base").nanoseconds == 2 * SECOND


def test_stamped_messages_are_transformed(packages: Any) -> None:
    buffer = buffer_with(packages, transform("odom", "base", x=2.0, yaw=math.pi / 2), static=True)
    point = PointStamped(header=Header(frame_id="base"), point=Point(x=1.0))
    found = buffer.transform(point, "odom")
    assert (found.header.frame_id, found.point.x, found.point.y) == (
        "odom",
        *map(pytest.approx, (2, 1)),
    )
    pose = PoseWithCovarianceStamped(header=point.header)
    pose.pose.covariance[0] = 4.0  # along base's x, which is odom's y
    moved = buffer.transform(pose, "odom")
    assert moved.pose.covariance[7] == pytest.approx(4.0)
    assert moved.pose.pose.orientation.z == pytest.approx(math.sin(math.pi / 4))
    with pytest.raises(packages.tf2_ros.TypeException):
        buffer.transform(Header(), "odom")


def test_a_coroutine_may_wait_for_a_transform(packages: Any) -> None:
    buffer = packages.tf2_ros.Buffer()
    waiting = buffer.lookup_transform_async("odom", "base", Time())
    waiting.send(None)  # it waits
    buffer.set_transform(transform("odom", "base", x=3.0, at=1.0), "test")
    with pytest.raises(StopIteration) as done:
        waiting.send(None)
    assert done.value.value.transform.translation.x == 3.0


# --- filters of messages --------------------------------------------------------------------------


def test_messages_are_put_together_by_their_stamps(packages: Any) -> None:
    filters = importlib.import_module("message_filters")
    left, right, found = filters.SimpleFilter(), filters.SimpleFilter(), []

    def put_together(first: Any, second: Any, how: str) -> None:
        found.append((how, first.header.stamp.sec, second.header.stamp.nanosec // 10**6))

    exact = filters.TimeSynchronizer([left, right], 10)
    exact.registerCallback(put_together, "exact")
    near = filters.ApproximateTimeSynchronizer([left, right], 10, 0.1)
    near.registerCallback(put_together, "near")
    kept = filters.Cache(left, 2)
    for side, at in ((left, 1.0), (right, 1.05), (left, 2.0), (right, 2.0), (left, 3.0),
                     (right, 3.1), (right, 3.09), (right, 3.08)):  # fmt: skip
        side.signalMessage(transform("odom", "base", at=at))
    assert found == [("near", 1, 50), ("exact", 2, 0), ("near", 2, 0), ("near", 3, 90)]
    two, then, nine = (Time(nanoseconds=n, clock_type=ClockType.ROS_TIME)
                       for n in (2 * SECOND, 2 * SECOND + 1, 9 * SECOND))  # fmt: skip
    assert [m.header.stamp.sec for m in kept.getInterval(two, nine)] == [2, 3]
    assert kept.getElemBeforeTime(two).header.stamp.sec == 2
    assert kept.getElemAfterTime(then) is kept.getLast()
