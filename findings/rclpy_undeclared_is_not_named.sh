#!/usr/bin/env bash
# Guess: set_parameters() with a parameter that was not declared names it, and sets nothing.
# Seen:  ParameterNotDeclaredException: "Invalid access to undeclared parameter(s): []". The list is
#        empty, and the parameters before it in the call have their new values, those after it not.
#        set_parameters_atomically() sets none, and names as little. get_parameter() names it.
# With:  ros-jazzy-rclpy 7.1.6 (Python 3.11 to 3.13), 2026-11-28
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" --quiet install ros-jazzy-rclpy==7.1.6 ros-jazzy-rmw-fastrtps-cpp==8.4.3
"$work/venv/bin/python" - > "$work/seen" <<'PY'
import rclpy
from rclpy.parameter import Parameter

rclpy.init()
node = rclpy.create_node("robot")
node.declare_parameter("speed", 1.0)
node.declare_parameter("turn", 1.0)
wanted = [Parameter(name, value=2.0) for name in ("speed", "sped", "turn")]
for call in (
    lambda: node.set_parameters_atomically(wanted),
    lambda: node.set_parameters(wanted),
    lambda: node.get_parameter("sped"),
):
    try:
        call()
    except rclpy.exceptions.ParameterNotDeclaredException as error:
        print(error, [node.get_parameter(name).value for name in ("speed", "turn")])
PY
diff "$work/seen" - <<'SEEN' && echo "as it was"
Invalid access to undeclared parameter(s): [] [1.0, 1.0]
Invalid access to undeclared parameter(s): [] [2.0, 1.0]
Invalid access to undeclared parameter(s): sped [2.0, 1.0]
SEEN
