#!/usr/bin/env bash
# Guess: an executor that was shut down raises when it is spun again, or at least waits for its
#        timeout; and it says what is wrong when something is added to it.
# Seen:  spin(), spin_once(timeout_sec=60) and spin_until_future_complete(…, timeout_sec=60) return at
#        once and in silence, so a loop around them takes a whole CPU, and an unfinished future looks
#        like one whose time is over. add_node() and create_task() raise AttributeError: 'NoneType'
#        object has no attribute 'trigger'; the node is in the executor all the same.
# With:  ros-jazzy-rclpy 7.1.6 (Python 3.11 to 3.13), 2026-11-28
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" --quiet install ros-jazzy-rclpy==7.1.6 ros-jazzy-rmw-fastrtps-cpp==8.4.3
"$work/venv/bin/python" - > "$work/seen" <<'PY'
import time

import rclpy
from rclpy.executors import MultiThreadedExecutor, SingleThreadedExecutor
from rclpy.task import Future

rclpy.init()
for kind in (SingleThreadedExecutor, MultiThreadedExecutor):
    executor = kind()
    executor.add_node(rclpy.create_node("first"))
    executor.shutdown()
    later = rclpy.create_node("later")
    began = time.monotonic()
    for name, call in {
        "spin": executor.spin,
        "spin_once": lambda: executor.spin_once(timeout_sec=60.0),
        "spin_until": lambda: executor.spin_until_future_complete(Future(), timeout_sec=60.0),
        "add_node": lambda: executor.add_node(later),
        "create_task": lambda: executor.create_task(print, "never"),
    }.items():
        try:
            print(name, call())
        except AttributeError as error:
            print(name, error)
    print("within a second:", time.monotonic() - began < 1.0, later in executor.get_nodes())
PY
for _ in 1 2; do cat <<'SEEN'; done | diff "$work/seen" - && echo "as it was"
spin None
spin_once None
spin_until None
add_node 'NoneType' object has no attribute 'trigger'
create_task 'NoneType' object has no attribute 'trigger'
within a second: True True
SEEN
