#!/usr/bin/env bash
# Guess: timer.timer_period_ns = … changes the timer: the next tick comes by the new period, or the
#        period begins anew.
# Seen:  the tick that is already due stays where it is. A timer of an hour that is set to 0.1 s is
#        silent for up to an hour more, and only then fast; one of 0.5 s that is set to an hour
#        ticks once more at once. reset() after the change makes the new period begin now.
# With:  ros-jazzy-rclpy 7.1.6, ros-jazzy-common-interfaces 5.3.6 (Python 3.11), 2026-11-29
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" --quiet install ros-jazzy-rclpy==7.1.6 ros-jazzy-common-interfaces==5.3.6 \
  ros-jazzy-rmw-fastrtps-cpp==8.4.3
ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST "$work/venv/bin/python" - > "$work/seen" <<'PY'
import rclpy


def left(timer):
    """Return how long it is till the next tick, in seconds."""
    return timer.time_until_next_call() / 1e9


rclpy.init()
node = rclpy.create_node("blinks")
timer = node.create_timer(3600.0, lambda: None)
timer.timer_period_ns = 10**8
print("3600 s, set to 0.1 s: next tick in more than 3000 s:", left(timer) > 3000)
timer.reset()
print("  and reset: in 0.1 s at most:", left(timer) <= 0.1)
timer.destroy()
ticks = []
timer = node.create_timer(0.5, lambda: ticks.append(len(ticks) + 1))
timer.timer_period_ns = 3600 * 10**9
print("0.5 s, set to 3600 s: next tick in 0.5 s at most:", left(timer) <= 0.5)
rclpy.spin_once(node, timeout_sec=60)
print("  ticks:", ticks, "the one after that in more than 3000 s:", left(timer) > 3000)
PY
diff "$work/seen" - <<'SEEN' && echo "as it was"
3600 s, set to 0.1 s: next tick in more than 3000 s: True
  and reset: in 0.1 s at most: True
0.5 s, set to 3600 s: next tick in 0.5 s at most: True
  ticks: [1] the one after that in more than 3000 s: True
SEEN
