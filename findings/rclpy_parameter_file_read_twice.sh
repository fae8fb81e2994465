#!/usr/bin/env bash
# Guess: a parameter file that is loaded into a running node (AsyncParameterClient's
#        load_parameter_file) sets what --params-file of the same file sets at its start, at least
#        where both parsers of YAML read the same values.
# Seen:  rclpy turns each value that it has read into a text, and reads the text as YAML again. So a
#        quoted "007" is sent as the integer 7, a quoted "on" as True; 0.00001 is sent as the text
#        1e-05, and .inf as the text inf, and a list with such a number in it as one long text: the
#        node refuses all of them for their type, 0.5 it takes.
# With:  ros-jazzy-rclpy 7.1.6 (Python 3.11), 2026-11-29
#        (the same with ros-kilted-rclpy 9.1.2, in other words)
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" --quiet install ros-jazzy-rclpy==7.1.6 ros-jazzy-rmw-fastrtps-cpp==8.4.3
cd "$work"
cat > robot.yaml <<'YAML'
/robot:
  ros__parameters:
    serial: "007"
    lamp: "on"
    gain: 0.00001
    farthest: .inf
    gains: [0.5, 0.00001]
    speed: 0.5
YAML
ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST "$work/venv/bin/python" - > "$work/seen" <<'PY'
import rclpy
import yaml
from rclpy.node import Node
from rclpy.parameter_client import AsyncParameterClient

DEFAULTS = {
    "serial": "none",
    "lamp": "off",
    "gain": 0.1,
    "farthest": 10.0,
    "gains": [0.1],
    "speed": 0.1,
}
with open("robot.yaml") as file:
    read = yaml.safe_load(file)["/robot"]["ros__parameters"]
rclpy.init()
options = ["--ros-args", "--params-file", "robot.yaml"]
for cli_args in (options, []):
    node = Node("robot", cli_args=cli_args)
    got = {key: node.declare_parameter(key, value).value for key, value in DEFAULTS.items()}
    if cli_args:
        print("at the start as PyYAML reads it:", {**got, "gains": list(got["gains"])} == read)
        node.destroy_node()
client = AsyncParameterClient(node, "robot")
client.wait_for_services(60)
future = client.load_parameter_file("robot.yaml")
rclpy.spin_until_future_complete(node, future, timeout_sec=60)
for key, result in zip(read, future.result().results, strict=True):
    print(key, repr(read[key]), result.successful, result.reason)
PY
diff "$work/seen" - <<'SEEN' && echo "as it was"
at the start as PyYAML reads it: True
serial '007' False Wrong parameter type, expected 'Type.STRING' got 'Type.INTEGER'
lamp 'on' False Wrong parameter type, expected 'Type.STRING' got 'Type.BOOL'
gain 1e-05 False Wrong parameter type, expected 'Type.DOUBLE' got 'Type.STRING'
farthest inf False Wrong parameter type, expected 'Type.DOUBLE' got 'Type.STRING'
gains [0.5, 1e-05] False Wrong parameter type, expected 'Type.DOUBLE_ARRAY' got 'Type.STRING'
speed 0.5 True 
SEEN
