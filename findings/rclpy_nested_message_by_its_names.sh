#!/usr/bin/env bash
# Guess: a Vector3 takes a Vector3; a Point, a Quaternion or an object of another library in its
#        place is refused, and a word that is no field of a message is, too.
# Seen:  what is sent is whatever has attributes of the fields' names. A Point drives the robot, as
#        does a Vector3 of rosbags or a SimpleNamespace; of a Quaternion x, y and z are taken, and w
#        is lost; a Duration is a stamp. A wrong word in the constructor is dropped, and the command
#        is 0; the same word as an attribute raises. ROS_PYTHON_CHECK_FIELDS=1 refuses them all.
# With:  ros-jazzy-rclpy 7.1.6, ros-jazzy-common-interfaces 5.3.6, rosbags 0.11.9 (Python 3.11),
#        2026-11-29
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" --quiet install ros-jazzy-rclpy==7.1.6 ros-jazzy-common-interfaces==5.3.6 \
  ros-jazzy-rmw-fastrtps-cpp==8.4.3 rosbags==0.11.9
cat > "$work/send.py" <<'PY'
from types import SimpleNamespace

from builtin_interfaces.msg import Duration, Time
from geometry_msgs.msg import Point, Quaternion, Twist, Vector3
from rclpy.serialization import deserialize_message, serialize_message
from rosbags.typesys import Stores, get_typestore
from std_msgs.msg import Header

bags = get_typestore(Stores.ROS2_JAZZY).types


def attribute():
    Twist().liner = Vector3(x=0.3)


def sent(make):
    try:
        message = make()
        again = deserialize_message(serialize_message(message), type(message))
    except (AssertionError, AttributeError) as error:
        return type(error).__name__
    value = again.linear if isinstance(again, Twist) else again.stamp
    return f"{str(value).partition('.msg.')[2]}, equal: {again == message}"


for name, make in {
    "Vector3": lambda: Twist(linear=Vector3(x=0.3)),
    "Point": lambda: Twist(linear=Point(x=0.3)),
    "Quaternion": lambda: Twist(linear=Quaternion(x=0.0, z=0.6, w=0.8)),
    "of rosbags": lambda: Twist(linear=bags["geometry_msgs/msg/Vector3"](0.3, 0.0, 0.0)),
    "names": lambda: Twist(linear=SimpleNamespace(x=0.3, y=0.0, z=0.0)),
    "dict": lambda: Twist(linear={"x": 0.3, "y": 0.0, "z": 0.0}),
    "Duration": lambda: Header(stamp=Duration(sec=3)),
    "Time": lambda: Header(stamp=Time(sec=3)),
    "wrong word": lambda: Twist(liner=Vector3(x=0.3)),
    "wrong attribute": attribute,
}.items():
    print(f"{name}: {sent(make)}")
PY
for check in "" 1; do
  ROS_PYTHON_CHECK_FIELDS=$check "$work/venv/bin/python" "$work/send.py"
done > "$work/seen"
diff "$work/seen" - <<'SEEN' && echo "as it was"
Vector3: Vector3(x=0.3, y=0.0, z=0.0), equal: True
Point: Vector3(x=0.3, y=0.0, z=0.0), equal: False
Quaternion: Vector3(x=0.0, y=0.0, z=0.6), equal: False
of rosbags: Vector3(x=0.3, y=0.0, z=0.0), equal: False
names: Vector3(x=0.3, y=0.0, z=0.0), equal: False
dict: AttributeError
Duration: Time(sec=3, nanosec=0), equal: False
Time: Time(sec=3, nanosec=0), equal: True
wrong word: Vector3(x=0.0, y=0.0, z=0.0), equal: True
wrong attribute: AttributeError
Vector3: Vector3(x=0.3, y=0.0, z=0.0), equal: True
Point: AssertionError
Quaternion: AssertionError
of rosbags: AssertionError
names: AssertionError
dict: AssertionError
Duration: AssertionError
Time: Time(sec=3, nanosec=0), equal: True
wrong word: AssertionError
wrong attribute: AttributeError
SEEN
