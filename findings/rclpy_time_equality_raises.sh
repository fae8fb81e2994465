#!/usr/bin/env bash
# Guess: two rclpy times can always be compared with ==, and Time() is a time like any other.
# Seen:  Time() is one of the SYSTEM clock, Time.from_msg() and a node's now() are of the ROS clock,
#        and between the two not only < and - but also == raises TypeError. So does `in` on a list.
#        Comparing with something that is no time at all is allowed, and False.
# With:  ros-jazzy-rclpy 7.1.6, ros-jazzy-common-interfaces 5.3.6 (Python 3.11 to 3.13), 2026-11-28
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" --quiet install ros-jazzy-rclpy==7.1.6 ros-jazzy-common-interfaces==5.3.6 \
  ros-jazzy-rmw-fastrtps-cpp==8.4.3
"$work/venv/bin/python" - > "$work/seen" <<'PY'
from rclpy.time import Time

stamped = Time.from_msg(Time(seconds=1).to_msg())
print(Time().clock_type.name, stamped.clock_type.name)
for name, ask in {
    "==": lambda: Time(seconds=1) == stamped,
    "in": lambda: stamped in [Time(seconds=1)],
    "<": lambda: Time() < stamped,
    "-": lambda: stamped - Time(),
    "== None": lambda: stamped == None,
}.items():
    try:
        print(name, ask())
    except TypeError as error:
        print(name, "raises:", error)
PY
diff "$work/seen" - <<'SEEN' && echo "as it was"
SYSTEM_TIME ROS_TIME
== raises: Can't compare times with different clock types
in raises: Can't compare times with different clock types
< raises: Can't compare times with different clock types
- raises: Can't subtract times with different clock types
== None False
SEEN
