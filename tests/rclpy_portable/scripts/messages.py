"""Serialize messages of many types, and values of wrong types; print what came out."""

import array
import math
from types import SimpleNamespace

import numpy as np
import rclpy.time
import rosgraph_msgs.msg
from builtin_interfaces.msg import Duration, Time
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import Point, PoseWithCovariance, Quaternion, Twist, Vector3
from rcl_interfaces.msg import ParameterEvent, ParameterValue
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import CompressedImage, JointState, LaserScan, PointCloud2, PointField
from std_msgs.msg import (
    Bool,
    Byte,
    ByteMultiArray,
    Char,
    Empty,
    Float32,
    Float64,
    Header,
    Int8,
    Int64,
    String,
    UInt8,
    UInt32,
)
from std_srvs.srv import SetBool, Trigger

MESSAGES = [
    Empty(), Bool(data=True), Byte(data=b"\x07"), Char(data=65), Int8(data=-3), UInt8(data=200),
    Int64(data=-(2**62)), UInt32(data=2**32 - 1), Float32(data=0.1), Float64(data=-math.inf),
    String(data="größer"), String(data=""), Time(sec=-1, nanosec=5),
    Twist(linear=Vector3(x=0.5), angular=Vector3(z=-1.25)),
    LaserScan(angle_min=-3.1, ranges=[1.0, math.inf, 0.25], intensities=array.array("f", [3.0])),
    LaserScan(ranges=np.linspace(0, 1, 5, dtype=np.float32)),
    JointState(name=["a", "bc", ""], position=[1.0, 2.0, 3.0]),
    PoseWithCovariance(covariance=np.arange(36.0)),
    DiagnosticArray(status=[DiagnosticStatus(level=b"\x02", name="x", message="y", hardware_id="z",
                                             values=[KeyValue(key="k", value="v")])]),
    ParameterEvent(node="/n"), ParameterValue(type=9, string_array_value=["q", "rs"]),
    ByteMultiArray(data=[b"\x01", b"\xff"]), CompressedImage(format="png", data=b"\x89PNG"),
    PointCloud2(fields=[PointField(name="x", offset=4, datatype=7, count=1)], data=b"\0" * 7),
    rosgraph_msgs.msg.Clock(), Trigger.Request(), Trigger.Response(success=True, message="m"),
    SetBool.Request(data=True),
]  # fmt: skip

for message in MESSAGES:
    again = deserialize_message(serialize_message(message), type(message))
    print(type(message).__name__, again == message, repr(again)[:300])

# Jazzy doesn't check fields by default: what a wrong value becomes
for message, field, value in (
    (Float64(), "data", 3), (Float64(), "data", 0), (Float64(), "data", -7),
    (Float64(), "data", 2**70), (Float64(), "data", True), (Float64(), "data", np.float64(1.5)),
    (Float32(), "data", 2), (Float32(), "data", 1e300), (Bool(), "data", 1), (Bool(), "data", 0),
    (Int64(), "data", True), (Int64(), "data", np.int32(-4)), (UInt32(), "data", np.uint8(4)),
    (UInt8(), "data", -1), (Int8(), "data", 300), (Int64(), "data", 1.5), (Int64(), "data", 2**63),
    (Float64(), "data", np.float32(1.5)), (Float64(), "data", np.int64(5)),
    (Float64(), "data", "text"), (Float64(), "data", [1.0, 2.0]),
    (LaserScan(), "ranges", [1, 2]), (LaserScan(), "ranges", (0.5,)),
    (Twist(), "linear", Point(x=0.3, z=2.0)), (Twist(), "linear", Quaternion(x=1.0)),
    (Twist(), "linear", 0.3), (Twist(), "linear", SimpleNamespace(x=1.0, y=2.0)),
    (Header(), "stamp", Duration(sec=3)), (Header(), "stamp", rclpy.time.Time(nanoseconds=5)),
    (String(), "data", 5), (String(), "data", b"b"), (KeyValue(), "value", None),
):  # fmt: skip
    setattr(message, field, value)
    try:
        again = deserialize_message(serialize_message(message), type(message))
    except Exception as error:
        said = error if isinstance(error, AttributeError | TypeError) else ""
        print(type(message).__name__, type(value).__name__, type(error).__name__, said)
        continue
    print(type(message).__name__, type(value).__name__, repr(getattr(again, field)))

for value in (np.array([0.3]), np.array(0.3), array.array("d", [0.3])):  # part of a pointer
    again = deserialize_message(serialize_message(Float64(data=value)), Float64)
    print(type(value).__name__, abs(again.data) < 1e-300)
