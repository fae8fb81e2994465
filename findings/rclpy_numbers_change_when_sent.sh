#!/usr/bin/env bash
# Guess: a message that comes back is equal to the one that was sent, and a number too big for its
#        field is refused.
# Seen:  a float32 array rounds its numbers when it is assigned, a single float32 field only when
#        it is sent: the scan keeps its ranges, but its angle_increment comes back as another
#        number. A single integer field wraps without a word, where the same number in an array is
#        refused by Python's own; a float32 becomes inf in both.
# With:  ros-jazzy-rclpy 7.1.6, ros-jazzy-common-interfaces 5.3.6 (Python 3.11 to 3.13), 2026-11-28
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" --quiet install ros-jazzy-rclpy==7.1.6 ros-jazzy-common-interfaces==5.3.6 \
  ros-jazzy-rmw-fastrtps-cpp==8.4.3
"$work/venv/bin/python" - > "$work/seen" <<'PY'
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Float32, Int32, UInt8, UInt8MultiArray, UInt16


def sent(message):
    return deserialize_message(serialize_message(message), type(message))


scan = LaserScan(angle_increment=0.1, ranges=[0.1])
again = sent(scan)
print("equal", scan == again)
print("ranges", scan.ranges == again.ranges, scan.ranges[0])
print("angle_increment", scan.angle_increment, again.angle_increment)
for message in (UInt8(data=300), UInt16(data=70_000), Int32(data=2**31), Float32(data=1e39)):
    print(type(message).__name__, message.data, sent(message).data)
print("array of float32", LaserScan(ranges=[1e39]).ranges[0])
try:
    UInt8MultiArray(data=[300])
except OverflowError as error:
    print("array of uint8 raises:", error)
PY
diff "$work/seen" - <<'SEEN' && echo "as it was"
equal False
ranges True 0.10000000149011612
angle_increment 0.1 0.10000000149011612
UInt8 300 44
UInt16 70000 4464
Int32 2147483648 -2147483648
Float32 1e+39 inf
array of float32 inf
array of uint8 raises: unsigned byte integer is greater than maximum
SEEN
