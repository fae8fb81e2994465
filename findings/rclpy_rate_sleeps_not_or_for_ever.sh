#!/usr/bin/env bash
# Guess: Rate.sleep() in a callback of a SingleThreadedExecutor hangs for good, since nobody is left
#        to call the rate's timer ("may block forever" in its docstring); where it returns, it has
#        slept.
# Seen:  it hangs only if the rate has not ticked since the last sleep. A tick that nobody waited
#        for is kept, so the next sleep() takes no time at all, and the one after it hangs, till
#        rclpy.shutdown(); however many ticks there were, they count as one. So a callback that is
#        called more seldom than the rate ticks, and sleeps once, looks sound and never waits; in a
#        loop it is the second round that hangs.
# With:  ros-jazzy-rclpy 7.1.6 (Python 3.11), 2026-11-29
#        (the same with ros-kilted-rclpy 9.1.2)
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" --quiet install ros-jazzy-rclpy==7.1.6 ros-jazzy-rmw-fastrtps-cpp==8.4.3
ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST "$work/venv/bin/python" - > "$work/seen" <<'PY'
import threading
import time

import rclpy
from rclpy.exceptions import ROSInterruptException
from rclpy.executors import SingleThreadedExecutor

PERIOD = 0.5


def sleep_often():
    """Sleep until that is interrupted; three periods from now nobody need wait any longer."""
    threading.Timer(3 * PERIOD, rclpy.try_shutdown).start()
    try:
        for _ in range(4):
            began = time.monotonic()
            rate.sleep()
            print("  slept", "a while" if time.monotonic() - began > PERIOD / 2 else "not at all")
    except ROSInterruptException:
        late = time.monotonic() - began > 2 * PERIOD
        print("  hung", "for more than two periods, until shutdown" if late else "not long")


for ticks in (0, 1, 3):
    rclpy.init()
    node, executor = rclpy.create_node("works"), SingleThreadedExecutor()
    executor.add_node(node)
    rate = node.create_rate(1 / PERIOD)
    for _ in range(ticks):  # the timer of the rate is all that there is to call
        executor.spin_once(timeout_sec=60)
    print("ticks before the callback:", ticks)
    executor.spin_until_future_complete(executor.create_task(sleep_often), timeout_sec=60)
PY
diff "$work/seen" - <<'SEEN' && echo "as it was"
ticks before the callback: 0
  hung for more than two periods, until shutdown
ticks before the callback: 1
  slept not at all
  hung for more than two periods, until shutdown
ticks before the callback: 3
  slept not at all
  hung for more than two periods, until shutdown
SEEN
