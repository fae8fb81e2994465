#!/usr/bin/env bash
# Guess: a timer's callback that takes a TimerInfo gets it, as a subscription's second parameter gets
#        the MessageInfo: by how many parameters there are, or by their type hints.
# Seen:  only a parameter whose annotation IS the class TimerInfo gets it. Written as a text (so, too,
#        below `from __future__ import annotations`, up to Python 3.13), as `TimerInfo | None`, or
#        without an annotation, the callback is called with nothing: TypeError, and the spin ends. The
#        subscription's goes by their number.
# With:  ros-kilted-rclpy 9.1.2 (Python 3.11 to 3.13), 2026-11-28
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" --quiet install ros-kilted-rclpy==9.1.2 ros-kilted-common-interfaces==5.5.1 \
  ros-kilted-rmw-fastrtps-cpp==9.3.3
ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST "$work/venv/bin/python" -u - > "$work/seen" <<'PY'
import rclpy
from rclpy.timer import TimerInfo
from std_msgs.msg import String


def by_class(info: TimerInfo): print("class:", type(info).__name__)
def by_text(info: "TimerInfo"): print("text:", type(info).__name__)
def optional(info: TimerInfo | None): print("optional:", type(info).__name__)
def bare(info): print("bare:", type(info).__name__)
def heard(message, info): print("subscription:", sorted(info)[0])


rclpy.init()
for tick in (by_class, by_text, optional, bare):
    node = rclpy.create_node("timed")
    node.create_timer(0.01, tick)
    try:
        rclpy.spin_once(node, timeout_sec=60)
    except TypeError as error:
        print(error)
    node.destroy_node()
node = rclpy.create_node("hears")
seen = []
node.create_subscription(String, "x", lambda message, info: seen.append(heard(message, info)), 1)
publisher = node.create_publisher(String, "x", 1)
while not seen:
    publisher.publish(String())
    rclpy.spin_once(node, timeout_sec=0.1)
PY
diff "$work/seen" - <<'SEEN' && echo "as it was"
class: TimerInfo
by_text() missing 1 required positional argument: 'info'
optional() missing 1 required positional argument: 'info'
bare() missing 1 required positional argument: 'info'
subscription: publication_sequence_number
SEEN
