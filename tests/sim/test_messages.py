"""The CDR of our messages, against rosbags and byte by byte."""

import contextlib
import math
import struct
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sim import messages
from sim.messages import EPOCH_NS, Message, decode, encode, twist_from_cdr

SETTINGS = settings(derandomize=True, deadline=None, max_examples=60)
times = st.integers(0, 3600 * 10**9)
numbers = st.floats(allow_nan=True, allow_infinity=True)


def scan(ranges, time=1_500_000_007, **changes):
    geometry = {
        "angle_min": -math.pi,
        "angle_increment": math.tau / 360,
        "range_min": 0.15,
        "range_max": 12.0,
    }
    return messages.laser_scan(time=time, ranges=ranges, **{**geometry, **changes})


@SETTINGS
@given(times, st.tuples(numbers, numbers, st.floats(-4, 4)), st.tuples(numbers, numbers))
def test_odometry_says_what_it_was_given(time, pose, speeds):
    (x, y, yaw), (v, w) = pose, speeds
    message = messages.odometry(time=time + 5, stamp=time, x=x, y=y, yaw=yaw, v=v, w=w)
    value = decode(message.data, message.type)
    assert encode(value, message.type) == message.data
    seconds, nanoseconds = divmod(EPOCH_NS + time, 10**9)
    assert (value.header.stamp.sec, value.header.stamp.nanosec) == (seconds, nanoseconds)
    assert (value.header.frame_id, value.child_frame_id) == ("odom", "base_link")
    position, speed = value.pose.pose.position, value.twist.twist
    sent = [position.x, position.y, speed.linear.x, speed.angular.z]
    assert np.array_equal(sent, [x, y, v, w], equal_nan=True)
    turn = value.pose.pose.orientation
    assert 2 * math.atan2(turn.z, turn.w) == pytest.approx(yaw)
    assert not value.pose.covariance.any()
    assert not value.twist.covariance.any()


@pytest.mark.parametrize(
    ("stamp", "seconds"),
    [(None, 1_700_000_001), (-(10**10), 1_699_999_990), (-messages.EPOCH_NS, 0)],
)
def test_a_goal_may_have_another_stamp(stamp: int | None, seconds: int) -> None:
    message = messages.pose_stamped(time=10**9, x=5.0, y=3.0, stamp=stamp)
    value = decode(message.data, "geometry_msgs/msg/PoseStamped")
    assert (message.topic, message.time, value.header.frame_id) == ("/goal_pose", 10**9, "odom")
    assert value.header.stamp.sec == seconds
    assert (value.pose.position.x, value.pose.position.y) == (5.0, 3.0)
    turn = value.pose.orientation
    assert messages.pose_from_cdr(message.data) == (5.0, 3.0, 0.0, turn.x, turn.y, turn.z, turn.w)


@pytest.mark.parametrize(
    ("message", "value"),
    [
        (messages.float64("/closing_speed", 3, 0.25), 0.25),
        (messages.bool_("/e_stop", 3, True), True),
        (messages.string("/detection", 3, "grün"), "grün"),
        (messages.uint32("/heartbeat", 3, 7), 7),
    ],
    ids=lambda v: v.type if isinstance(v, Message) else "",
)
def test_a_simple_message_decodes_to_what_went_in(message, value):
    assert decode(message.data, message.type).data == value
    assert message.time == 3


def test_a_twist_has_the_bytes_of_rosbags_and_comes_back():
    message = messages.twist(time=1, linear_x=0.5, angular_z=-1.25)
    assert encode(decode(message.data, message.type), message.type) == message.data
    assert twist_from_cdr(message.data) == (0.5, 0, 0, 0, 0, -1.25)
    big_endian = b"\0\0\0\0" + struct.pack(">6d", 1, 2, 3, 4, 5, 6)
    assert twist_from_cdr(big_endian) == (1, 2, 3, 4, 5, 6)


@SETTINGS
@given(st.binary(max_size=60))
def test_bytes_that_are_no_twist_are_refused(data):
    if len(data) == 52 and data[:2] in (b"\0\0", b"\0\1"):
        assert len(twist_from_cdr(data)) == 6
        return
    with pytest.raises(ValueError, match="not a Twist: expected 52 bytes of plain CDR, got"):
        twist_from_cdr(data)


def test_a_stamped_twist_is_read_and_a_short_one_refused():
    types = messages.typestore().types
    twist = decode(b"\0\1\0\0" + struct.pack("<6d", 1, 2, 3, 4, 5, 6), messages.TWIST)
    stamp = types["builtin_interfaces/msg/Time"](sec=1, nanosec=2)
    for frame in ("", "base_link"):
        header = types["std_msgs/msg/Header"](stamp=stamp, frame_id=frame)
        value = types[messages.TWIST_STAMPED](header=header, twist=twist)
        data = encode(value, messages.TWIST_STAMPED)
        assert messages.twist_stamped_from_cdr(data) == (1, 2, 3, 4, 5, 6)
    with pytest.raises(ValueError, match="too few"):
        messages.twist_stamped_from_cdr(data[:52])


@SETTINGS
@given(st.binary(max_size=100))
def test_decode_raises_nothing_but_value_error(data):
    for type_ in (messages.LASER_SCAN, messages.STRING, messages.ODOMETRY):
        with contextlib.suppress(ValueError):
            decode(data, type_)
    with pytest.raises(ValueError, match="unknown message type 'a/msg/B'"):
        decode(data, "a/msg/B")


def test_importing_the_simulation_loads_neither_rosbags_nor_rclpy_and_sim_nothing():
    code = "import sys, sim; print(sorted({'rosbags', 'pymunk', 'numpy'} & set(sys.modules)));"
    code += "import sim.simulation; print(sorted({'rosbags', 'rclpy'} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["[]", "[]"]


def test_a_message_can_be_of_another_epoch() -> None:
    today = 1_795_260_000 * 10**9 + 7
    message = scan(np.ones(3, np.float32), time=1_500_000_000)
    moved = messages.with_epoch(message, today)

    stamp = decode(moved.data, moved.type).header.stamp
    assert stamp.sec * 10**9 + stamp.nanosec == today + 1_500_000_000
    assert moved.time == message.time
    assert moved.data[12:] == message.data[12:]
    assert messages.with_epoch(message, EPOCH_NS) == message
    headless = messages.twist(time=5, linear_x=0.1)
    assert messages.with_epoch(headless, 0) is headless


def test_padding_is_no_part_of_a_message():
    kind = "diagnostic_msgs/msg/DiagnosticStatus"
    status = messages.typestore().types[kind](
        level=1, name="n", message="m", hardware_id="", values=[]
    )
    data = encode(status, kind)
    noisy = bytearray(data)
    noisy[5:8] = b"\xde\xad\xbe"  # between the level, a byte, and the length of the name
    assert messages.canonical(bytes(noisy), kind) == data != noisy


@pytest.mark.parametrize(("data", "type"), [(b"", "std_msgs/msg/String"), (b"x", "my/msg/Own")])
def test_what_is_no_message_stays_as_it_is(data, type):
    assert messages.canonical(data, type) == data


@pytest.mark.parametrize("frame", ["laser", "laser_frame", "", "lidär"])
def test_what_is_packed_here_is_what_rosbags_writes_and_reads(frame):
    made = [
        scan([1.0, math.nan, math.inf], frame_id=frame),
        scan([]),
        messages.odometry(time=7, x=1.0, y=math.nan, yaw=2.0, v=0.3, w=0.4, qw=0.5),
        messages.pose_stamped(time=7, x=1.0, y=2.0, yaw=0.3),
        messages.transform(time=7, parent="odom", child=frame, x=1.0, y=2.0, yaw=0.3),
        messages.float64("/a", 7, 0.1),
        messages.bool_("/a", 7, True),
        messages.string("/a", 7, frame),
        messages.uint32("/a", 7, 2**32 - 1),
    ]
    for message in made:
        assert encode(decode(message.data, message.type), message.type) == message.data
    value = decode(made[0].data, made[0].type)
    stamp, numbers, ranges = messages.scan_from_cdr(made[0].data)
    assert stamp == value.header.stamp.sec * 10**9 + value.header.stamp.nanosec
    fields = ("angle_min", "angle_max", "angle_increment", "time_increment", "scan_time")
    assert numbers == tuple(getattr(value, f) for f in (*fields, "range_min", "range_max"))
    assert ranges.tobytes() == value.ranges.tobytes()
    pose, speeds = messages.odometry_from_cdr(made[2].data)
    assert np.array_equal(pose[:3], [1.0, math.nan, 0.0], equal_nan=True)
    assert (pose[6], speeds) == (0.5, (0.3, 0.0, 0.0, 0.0, 0.0, 0.4))


@pytest.mark.parametrize("read", [messages.scan_from_cdr, messages.odometry_from_cdr])
def test_bytes_that_are_no_message_are_refused(read):
    for whole in (scan([1.0, 2.0]), messages.odometry(time=7, x=1.0, y=2.0, yaw=2.0)):
        for size in (0, 4, 12, 20, 50):
            with pytest.raises(ValueError, match=r"bytes|buffer"):
                read(whole.data[:size])
        with pytest.raises(ValueError, match="CDR"):
            read(b"\x07" + whole.data)
