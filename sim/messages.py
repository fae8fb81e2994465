"""ROS 2 messages as CDR bytes, without ROS: all that the robot and a node exchange.

Every message is little-endian CDR with its 4-byte encapsulation header. What the robot says is
packed here; rosbags, which takes long to import, reads and writes any other message of Jazzy.

Units and frames follow REP-103 and REP-105: metres, radians, x ahead, y to the left.
"""

import math
import struct
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

EPOCH_NS = 1_700_000_000 * 10**9  # ROS time at scenario time 0 [ns]

SCAN_TOPIC = "/scan"
ODOM_TOPIC = "/odom"
GOAL_TOPIC = "/goal_pose"
CMD_VEL_TOPIC = "/cmd_vel"
CMD_VEL_RAW_TOPIC = "/cmd_vel_raw"
E_STOP_TOPIC = "/e_stop"
TF_TOPIC = "/tf"
TF_STATIC_TOPIC = "/tf_static"

LASER_SCAN = "sensor_msgs/msg/LaserScan"
ODOMETRY = "nav_msgs/msg/Odometry"
POSE_STAMPED = "geometry_msgs/msg/PoseStamped"
TWIST = "geometry_msgs/msg/Twist"
TWIST_STAMPED = "geometry_msgs/msg/TwistStamped"
FLOAT64 = "std_msgs/msg/Float64"
BOOL = "std_msgs/msg/Bool"
STRING = "std_msgs/msg/String"
UINT32 = "std_msgs/msg/UInt32"
TF_MESSAGE = "tf2_msgs/msg/TFMessage"

LATCHED = frozenset({TF_STATIC_TOPIC})  # sent once: who comes later hears the last message

LASER_FRAME = "laser"
ODOM_FRAME = "odom"
BASE_FRAME = "base_link"

_STAMP = struct.Struct("<iI")  # both headers begin with it, right after the encapsulation
_STAMP_AT = 4
_PLAIN = b"\0\1\0\0"  # little-endian CDR
_SCAN = struct.Struct("<7fI")
_POSE = struct.Struct("<7d")
_COVARIANCE = bytes(36 * 8)  # zeros
_SIX = struct.Struct("<6d")
_SIX_BIG_ENDIAN = struct.Struct(">6d")
_TWIST_BYTES = 4 + _SIX.size
_TWIST_STAMPED_LEAST = _TWIST_BYTES + 8 + 8  # stamp, and an empty frame with its padding


@dataclass(frozen=True, slots=True)
class Message:
    """One message on a topic."""

    topic: str  # "/scan"
    type: str  # "sensor_msgs/msg/LaserScan"
    time: int  # when it is delivered, since the scenario's start [ns]
    data: bytes  # CDR, little endian, with the 4-byte encapsulation header


@lru_cache(maxsize=1)
def typestore() -> Any:
    """Return rosbags' type store for ROS 2 Jazzy (made on first use: it takes 60 ms)."""
    from rosbags.typesys import Stores, get_typestore  # noqa: PLC0415

    return get_typestore(Stores.ROS2_JAZZY)


def encode(value: Any, type: str) -> bytes:
    """Return the CDR bytes of a rosbags message object of that type."""
    return bytes(typestore().serialize_cdr(value, type))


def decode(data: bytes, type: str) -> Any:
    """Return the rosbags message object in these CDR bytes.

    Raises ValueError: the type is not known, or the bytes are not a message of it.
    """
    if type not in typestore().fielddefs:
        raise ValueError(f"unknown message type {type!r}")
    try:
        return typestore().deserialize_cdr(data, type)
    except Exception as error:  # rosbags raises all kinds for broken bytes
        raise ValueError(f"{len(data)} bytes are not a {type}: {error}") from error


def canonical(data: bytes, type: str) -> bytes:
    """Return the bytes of the same message with zeros for padding.

    rclpy publishes whatever was in memory there. Bytes that are no message of a known type stay as
    they are.
    """
    try:
        return encode(decode(data, type), type)
    except ValueError:
        return data


def with_epoch(message: Message, epoch: int) -> Message:
    """Return the message of a scenario that starts at `epoch` [ns since 1970], not at EPOCH_NS.

    Only the stamp of a header at the beginning of the message is changed, or of its one transform;
    a stamp of 0 is none, and stays.
    """
    fields = typestore().fielddefs[message.type][1]
    at = _STAMP_AT
    if message.type == TF_MESSAGE:
        at += 4  # after the number of transforms
    elif not fields or fields[0][0] != "header":
        return message
    data = bytearray(message.data)
    seconds, nanoseconds = _STAMP.unpack_from(data, at)
    if not (seconds or nanoseconds):  # nobody stamped it
        return message
    stamp = seconds * 10**9 + nanoseconds - EPOCH_NS + epoch
    _STAMP.pack_into(data, at, *divmod(stamp, 10**9))
    return Message(message.topic, message.type, message.time, bytes(data))


def laser_scan(
    *,
    time: int,
    ranges: NDArray[np.float32],
    angle_min: float,
    angle_increment: float,
    range_min: float,
    range_max: float,
    scan_time: float = 0.1,
    stamp: int | None = None,
    frame_id: str = LASER_FRAME,
) -> Message:
    """Return a sensor_msgs/LaserScan with no intensities.

    Parameters
    ----------
    time, stamp
        Delivery and measurement since the scenario's start [ns]; `stamp` is `time` by default.
    ranges
        (n_beams,) float32 [m], readings as REP-117 defines them.
    angle_min, angle_increment
        Angle of the first beam and between beams [rad].
    range_min, range_max
        Limits of a valid reading [m].
    scan_time
        Between two scans [s].
    frame_id
        The frame in which its angles count.
    """
    angle_max = angle_min + max(len(ranges) - 1, 0) * angle_increment
    time_increment = 0.0  # the mock lidar measures all beams at once
    numbers = (angle_min, angle_max, angle_increment, time_increment, scan_time)
    data = (
        _header(time if stamp is None else stamp, frame_id)
        + _SCAN.pack(*numbers, range_min, range_max, len(ranges))
        + np.asarray(ranges, "<f4").tobytes()
        + bytes(4)  # no intensities
    )
    return Message(SCAN_TOPIC, LASER_SCAN, time, data)


def odometry(
    *,
    time: int,
    x: float,
    y: float,
    yaw: float,
    v: float = 0.0,
    w: float = 0.0,
    qw: float | None = None,
    stamp: int | None = None,
    topic: str = ODOM_TOPIC,
) -> Message:
    """Return a nav_msgs/Odometry of `base_link` in `odom` with zero covariances.

    Parameters
    ----------
    time, stamp
        Delivery and measurement since the scenario's start [ns]; `stamp` is `time` by default.
    x, y, yaw
        Pose [m, m, rad]; values that are not finite are sent as they are.
        `qw`, if given, is sent in place of the quaternion's w.
    v, w
        Forward and turning speed in base_link [m/s, rad/s].
    """
    data = (
        _header(time if stamp is None else stamp, ODOM_FRAME, BASE_FRAME, align=8)
        + _POSE.pack(x, y, 0.0, *_quaternion(yaw, qw))
        + _COVARIANCE
        + _SIX.pack(v, 0.0, 0.0, 0.0, 0.0, w)
        + _COVARIANCE
    )
    return Message(topic, ODOMETRY, time, data)


def pose_stamped(
    *,
    time: int,
    x: float,
    y: float,
    yaw: float = 0.0,
    w: float | None = None,
    stamp: int | None = None,
) -> Message:
    """Return a geometry_msgs/PoseStamped at that pose [m, m, rad], its quaternion's w if given.

    `time` and `stamp` are as in `odometry`; a stamp of -EPOCH_NS is 0, as nobody has set it.
    """
    header = _header(time if stamp is None else stamp, ODOM_FRAME, align=8)
    data = header + _POSE.pack(x, y, 0.0, *_quaternion(yaw, w))
    return Message(GOAL_TOPIC, POSE_STAMPED, time, data)


def transform(
    *,
    time: int,
    parent: str,
    child: str,
    x: float,
    y: float,
    yaw: float,
    topic: str = TF_TOPIC,
    stamp: int | None = None,
) -> Message:
    """Return a tf2_msgs/TFMessage: where the frame `child` is in `parent` [m, m, rad].

    `time` and `stamp` are as in `odometry`.
    """
    one = struct.pack("<I", 1)  # transform
    header = _header(time if stamp is None else stamp, parent, child, align=8, before=one)
    return Message(topic, TF_MESSAGE, time, header + _POSE.pack(x, y, 0.0, *_quaternion(yaw)))


def twist(
    *,
    time: int,
    linear_x: float = 0.0,
    others: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0),
    angular_z: float = 0.0,
    topic: str = CMD_VEL_TOPIC,
) -> Message:
    """Return a geometry_msgs/Twist; `others` are linear y, z [m/s] and angular x, y [rad/s]."""
    data = _PLAIN + _SIX.pack(linear_x, *others, angular_z)
    return Message(topic, TWIST, time, data)


def twist_from_cdr(data: bytes) -> tuple[float, float, float, float, float, float]:
    """Return linear x, y, z [m/s] and angular x, y, z [rad/s] of a geometry_msgs/Twist.

    Raises ValueError: the bytes are not a Twist: wrong length or not plain CDR.
    """
    if len(data) != _TWIST_BYTES or data[0] != 0 or data[1] not in (0, 1):
        start = bytes(data[:4]).hex()
        raise ValueError(
            f"not a Twist: expected {_TWIST_BYTES} bytes of plain CDR, "
            f"got {len(data)} bytes that begin with {start or 'nothing'}"
        )
    form = _SIX if data[1] else _SIX_BIG_ENDIAN
    lx, ly, lz, ax, ay, az = form.unpack_from(data, 4)
    return lx, ly, lz, ax, ay, az


def twist_stamped_from_cdr(data: bytes) -> tuple[float, float, float, float, float, float]:
    """Return the same as `twist_from_cdr` of a geometry_msgs/TwistStamped, which ends with a Twist.

    Raises ValueError: the bytes are too few or not plain CDR.
    """
    if len(data) < _TWIST_STAMPED_LEAST:
        raise ValueError(f"not a TwistStamped: {len(data)} bytes are too few")
    return twist_from_cdr(data[:4] + data[-_SIX.size :])


def scan_from_cdr(data: bytes) -> tuple[int, tuple[float, ...], NDArray[np.float32]]:
    """Return stamp [ns since 1970], numbers and (n,) ranges [m] of a sensor_msgs/LaserScan.

    The numbers are angle_min, angle_max, angle_increment, time_increment, scan_time, range_min and
    range_max. It raises ValueError as `odometry_from_cdr` does.
    """
    stamp, at, order = _after_header(data, names=1)
    *numbers, count = _unpacked(f"{order}7fI", data, at)
    return stamp, tuple(numbers), np.frombuffer(data, f"{order}f4", count, at + _SCAN.size)


def odometry_from_cdr(data: bytes) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Return pose (x, y, z and a quaternion) and twist (as `twist_from_cdr`) of an Odometry.

    Raises ValueError: the bytes are too few, or not plain CDR.
    """
    _, at, order = _after_header(data, names=2)
    at += (4 - at) % 8  # alignment counts from the end of the 4-byte encapsulation header
    twist_at = at + _POSE.size + len(_COVARIANCE)
    return _unpacked(f"{order}7d", data, at), _unpacked(f"{order}6d", data, twist_at)


def pose_from_cdr(data: bytes) -> tuple[float, ...]:
    """Return x, y, z and a quaternion of a PoseStamped; it raises as `odometry_from_cdr` does."""
    _, at, order = _after_header(data, names=1)
    return _unpacked(f"{order}7d", data, at + (4 - at) % 8)


def float64(topic: str, time: int, value: float) -> Message:
    """Return a std_msgs/Float64."""
    return Message(topic, FLOAT64, time, _PLAIN + struct.pack("<d", value))


def bool_(topic: str, time: int, value: bool) -> Message:
    """Return a std_msgs/Bool."""
    return Message(topic, BOOL, time, _PLAIN + struct.pack("<?", value))


def string(topic: str, time: int, value: str) -> Message:
    """Return a std_msgs/String."""
    return Message(topic, STRING, time, _PLAIN + _strings(value))


def uint32(topic: str, time: int, value: int) -> Message:
    """Return a std_msgs/UInt32."""
    return Message(topic, UINT32, time, _PLAIN + struct.pack("<I", value))


def half_angle(yaw: float) -> tuple[float, float]:
    """Return z and w of the quaternion of that yaw [rad]; NaN for a yaw that is not finite."""
    if not math.isfinite(yaw):
        return math.nan, math.nan
    return math.sin(yaw / 2), math.cos(yaw / 2)


def _header(time: int, *names: str, align: int = 4, before: bytes = b"") -> bytes:
    """Return all up to the first number after a header, whose frame a child's may follow."""
    stamp = before + _STAMP.pack(*divmod(EPOCH_NS + time, 10**9))
    text = _strings(*names)
    return _PLAIN + stamp + text + bytes(-(len(stamp) + len(text)) % align)


@lru_cache(maxsize=64)
def _strings(*texts: str) -> bytes:
    """Return strings that begin at a multiple of 4."""
    data = b""
    for text in texts:
        raw = text.encode() + b"\0"
        data += bytes(-len(data) % 4) + struct.pack("<I", len(raw)) + raw
    return data


def _after_header(data: bytes, names: int) -> tuple[int, int, str]:
    """Return the stamp [ns], where a header and its child's frame end, and the byte order."""
    if data[:1] != b"\0" or data[1:2] not in (b"\0", b"\1"):
        start = data[:4].hex() or "nothing"
        raise ValueError(f"not plain CDR: {len(data)} bytes that begin with {start}")
    order = "<" if data[1] else ">"
    seconds, nanoseconds = _unpacked(f"{order}iI", data, _STAMP_AT)
    at = _STAMP_AT + _STAMP.size
    for _ in range(names):
        (length,) = _unpacked(f"{order}I", data, at)
        at += 4 + length
        at += -at % 4
    return seconds * 10**9 + nanoseconds, at, order


def _unpacked(form: str, data: bytes, at: int) -> tuple[Any, ...]:
    try:
        return struct.unpack_from(form, data, at)
    except struct.error as error:
        raise ValueError(f"{len(data)} bytes are too few: {error}") from None


def _quaternion(yaw: float, w: float | None = None) -> tuple[float, float, float, float]:
    z, own = half_angle(yaw)
    return 0.0, 0.0, z, own if w is None else w
