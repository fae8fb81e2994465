#!/usr/bin/env bash
# Guess: a message equals itself and a copy of it, so `new == last` tells whether something changed.
# Seen:  a LaserScan with a NaN among its ranges (as many lidars send where nothing comes back) is
#        not equal to itself, while `scan in [scan]` is True.
#        With inf in place of NaN all are equal.
# With:  ros-jazzy-common-interfaces 5.3.6 (Python 3.11 to 3.13), 2026-11-28
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" --quiet install ros-jazzy-rclpy==7.1.6 ros-jazzy-common-interfaces==5.3.6 \
  ros-jazzy-rmw-fastrtps-cpp==8.4.3
"$work/venv/bin/python" - > "$work/seen" <<'PY'
import copy
import math

from sensor_msgs.msg import LaserScan

scan = LaserScan(ranges=[1.0, math.nan])
print(scan == scan, scan in [scan], copy.deepcopy(scan) == scan)
whole = LaserScan(ranges=[1.0, math.inf])
print(whole == whole, copy.deepcopy(whole) == whole)
PY
diff "$work/seen" - <<'SEEN' && echo "as it was"
False True False
True True
SEEN
