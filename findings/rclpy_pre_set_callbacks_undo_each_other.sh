#!/usr/bin/env bash
# Guess: two pre-set-parameters callbacks work one after the other: the second gets what the first
#        has returned, and what one has clamped stays clamped.
# Seen:  each gets the list that was asked for, and their lists are put together, the newest
#        callback's first. The parameter is then in it twice, and the last one counts. So one that
#        returns its list as it is undoes a clamp, if it was added before it; on-set and post-set
#        callbacks see both values, and the result says successful.
# With:  ros-jazzy-rclpy 7.1.6 (Python 3.11), 2026-11-29
#        (the same with ros-kilted-rclpy 9.1.2)
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" --quiet install ros-jazzy-rclpy==7.1.6 ros-jazzy-rmw-fastrtps-cpp==8.4.3
ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST "$work/venv/bin/python" - > "$work/seen" <<'PY'
import rclpy
from rcl_interfaces.msg import SetParametersResult
from rclpy.parameter import Parameter


def values(parameters):
    return [parameter.value for parameter in parameters]


def clamp(parameters):
    print("  clamp gets", values(parameters))
    return [Parameter(each.name, value=min(each.value, 0.5)) for each in parameters]


def watch(parameters):
    print("  watch gets", values(parameters))
    return parameters


def accept(parameters):
    print("  on-set gets", values(parameters))
    return SetParametersResult(successful=True)


rclpy.init()
for i, callbacks in enumerate(((clamp,), (clamp, watch), (watch, clamp))):
    print("added:", *(callback.__name__ for callback in callbacks))
    node = rclpy.create_node(f"robot_{i}")
    node.declare_parameter("speed", 0.1)
    for callback in callbacks:
        node.add_pre_set_parameters_callback(callback)
    node.add_on_set_parameters_callback(accept)
    node.add_post_set_parameters_callback(lambda got: print("  post-set gets", values(got)))
    (result,) = node.set_parameters([Parameter("speed", value=2.0)])
    print("  speed", node.get_parameter("speed").value, result.successful)
PY
diff "$work/seen" - <<'SEEN' && echo "as it was"
added: clamp
  clamp gets [2.0]
  on-set gets [0.5]
  post-set gets [0.5]
  speed 0.5 True
added: clamp watch
  watch gets [2.0]
  clamp gets [2.0]
  on-set gets [2.0, 0.5]
  post-set gets [2.0, 0.5]
  speed 0.5 True
added: watch clamp
  clamp gets [2.0]
  watch gets [2.0]
  on-set gets [0.5, 2.0]
  post-set gets [0.5, 2.0]
  speed 2.0 True
SEEN
