"""ROS 2 messages as CDR bytes, without ROS: all that the robot and a node exchange.

Every message is little-endian CDR with its 4-byte encapsulation header, serialised by rosbags from
the definitions of ROS 2 Jazzy.

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

OFFERED = {  # what a scenario can have the robot send: topic → type
    SCAN_TOPIC: LASER_SCAN,
    ODOM_TOPIC: ODOMETRY,
    GOAL_TOPIC: POSE_STAMPED,
    CMD_VEL_RAW_TOPIC: TWIST,
    E_STOP_TOPIC: BOOL,
    TF_TOPIC: TF_MESSAGE,
    TF_STATIC_TOPIC: TF_MESSAGE,
}
LATCHED = frozenset({TF_STATIC_TOPIC})  # sent once: who comes later hears the last message
SENSORS = frozenset({SCAN_TOPIC, ODOM_TOPIC})  # the topics to which `[qos] sensors` applies

LASER_FRAME = "laser"
ODOM_FRAME = "odom"
BASE_FRAME = "base_link"

_STAMP = struct.Struct("<iI")  # both headers begin with it, right after the encapsulation
_STAMP_AT = 4
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

    Raises
    ------
    ValueError
        The type is not known, or the bytes are not a message of it.
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
    value = typestore().types[LASER_SCAN](
        header=_header(time if stamp is None else stamp, frame_id),
        angle_min=angle_min,
        angle_max=angle_min + max(len(ranges) - 1, 0) * angle_increment,
        angle_increment=angle_increment,
        time_increment=0.0,  # the mock lidar measures all beams at once
        scan_time=scan_time,
        range_min=range_min,
        range_max=range_max,
        ranges=np.asarray(ranges, np.float32),
        intensities=np.zeros(0, np.float32),
    )
    return Message(SCAN_TOPIC, LASER_SCAN, time, encode(value, LASER_SCAN))


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
    types = typestore().types
    value = types[ODOMETRY](
        header=_header(time if stamp is None else stamp, ODOM_FRAME),
        child_frame_id=BASE_FRAME,
        pose=types["geometry_msgs/msg/PoseWithCovariance"](_pose(x, y, yaw, qw), np.zeros(36)),
        twist=types["geometry_msgs/msg/TwistWithCovariance"](
            types[TWIST](linear=_vector(x=v), angular=_vector(z=w)), np.zeros(36)
        ),
    )
    return Message(topic, ODOMETRY, time, encode(value, ODOMETRY))


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
    header = _header(time if stamp is None else stamp, ODOM_FRAME)
    value = typestore().types[POSE_STAMPED](header=header, pose=_pose(x, y, yaw, w))
    return Message(GOAL_TOPIC, POSE_STAMPED, time, encode(value, POSE_STAMPED))


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
    types = typestore().types
    value = types["geometry_msgs/msg/TransformStamped"](
        header=_header(time if stamp is None else stamp, parent),
        child_frame_id=child,
        transform=types["geometry_msgs/msg/Transform"](
            translation=_vector(x=x, y=y), rotation=_quaternion(yaw)
        ),
    )
    return Message(topic, TF_MESSAGE, time, encode(types[TF_MESSAGE]([value]), TF_MESSAGE))


def twist(
    *,
    time: int,
    linear_x: float = 0.0,
    others: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0),
    angular_z: float = 0.0,
    topic: str = CMD_VEL_TOPIC,
) -> Message:
    """Return a geometry_msgs/Twist; `others` are linear y, z [m/s] and angular x, y [rad/s]."""
    data = b"\0\1\0\0" + _SIX.pack(linear_x, *others, angular_z)
    return Message(topic, TWIST, time, data)


def twist_from_cdr(data: bytes) -> tuple[float, float, float, float, float, float]:
    """Return linear x, y, z [m/s] and angular x, y, z [rad/s] of a geometry_msgs/Twist.

    Raises
    ------
    ValueError
        The bytes are not a Twist: wrong length or not plain CDR.
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

    Raises
    ------
    ValueError
        The bytes are too few or not plain CDR.
    """
    if len(data) < _TWIST_STAMPED_LEAST:
        raise ValueError(f"not a TwistStamped: {len(data)} bytes are too few")
    return twist_from_cdr(data[:4] + data[-_SIX.size :])


def float64(topic: str, time: int, value: float) -> Message:
    """Return a std_msgs/Float64."""
    return _std(topic, FLOAT64, time, float(value))


def bool_(topic: str, time: int, value: bool) -> Message:
    """Return a std_msgs/Bool."""
    return _std(topic, BOOL, time, bool(value))


def string(topic: str, time: int, value: str) -> Message:
    """Return a std_msgs/String."""
    return _std(topic, STRING, time, value)


def uint32(topic: str, time: int, value: int) -> Message:
    """Return a std_msgs/UInt32."""
    return _std(topic, UINT32, time, int(value))


def half_angle(yaw: float) -> tuple[float, float]:
    """Return z and w of the quaternion of that yaw [rad]; NaN for a yaw that is not finite."""
    if not math.isfinite(yaw):
        return math.nan, math.nan
    return math.sin(yaw / 2), math.cos(yaw / 2)


def _std(topic: str, type: str, time: int, value: float | bool | int | str) -> Message:
    return Message(topic, type, time, encode(typestore().types[type](data=value), type))


def _header(time: int, frame_id: str) -> Any:
    types = typestore().types
    seconds, nanoseconds = divmod(EPOCH_NS + time, 10**9)
    stamp = types["builtin_interfaces/msg/Time"](sec=seconds, nanosec=nanoseconds)
    return types["std_msgs/msg/Header"](stamp=stamp, frame_id=frame_id)


def _quaternion(yaw: float, w: float | None = None) -> Any:
    z, own = half_angle(yaw)
    w = own if w is None else w
    return typestore().types["geometry_msgs/msg/Quaternion"](x=0.0, y=0.0, z=z, w=w)


def _pose(x: float, y: float, yaw: float, w: float | None) -> Any:
    types = typestore().types
    point = types["geometry_msgs/msg/Point"](x=x, y=y, z=0.0)
    return types["geometry_msgs/msg/Pose"](position=point, orientation=_quaternion(yaw, w))


def _vector(x: float = 0.0, y: float = 0.0, z: float = 0.0) -> Any:
    return typestore().types["geometry_msgs/msg/Vector3"](x=x, y=y, z=z)
