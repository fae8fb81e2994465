#!/usr/bin/env bash
# Guess: declare_parameter("stops", []) makes a list that takes stops later, and a list parameter
#        can be emptied by Parameter("stops", value=[]).
# Seen:  an empty list has the type BYTE_ARRAY, in both directions. So a parameter declared with []
#        refuses texts and numbers alike, at run time by a result, at the start by an exception,
#        and a list of texts refuses the empty list unless its type is said.
# With:  ros-jazzy-rclpy 7.1.6 (Python 3.11 to 3.13), 2026-11-28
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" --quiet install ros-jazzy-rclpy==7.1.6 ros-jazzy-rmw-fastrtps-cpp==8.4.3
"$work/venv/bin/python" - > "$work/seen" <<'PY'
import rclpy
from rclpy.exceptions import InvalidParameterTypeException
from rclpy.node import Node
from rclpy.parameter import Parameter

rclpy.init()
node = Node("shuttle", parameter_overrides=[Parameter("given", value=["a"])])
print(node.declare_parameter("stops", []).type_.name)
node.declare_parameter("words", ["a"])
for parameter in (
    Parameter("stops", value=["a"]),
    Parameter("stops", value=[1.0]),
    Parameter("words", value=[]),
    Parameter("words", Parameter.Type.STRING_ARRAY, []),
):
    (result,) = node.set_parameters([parameter])
    print(parameter.name, parameter.value, result.successful, result.reason)
try:
    node.declare_parameter("given", [])
except InvalidParameterTypeException as error:
    print("raises:", error)
PY
diff "$work/seen" - <<'SEEN' && echo "as it was"
BYTE_ARRAY
stops ['a'] False Wrong parameter type, expected 'Type.BYTE_ARRAY' got 'Type.STRING_ARRAY'
stops [1.0] False Wrong parameter type, expected 'Type.BYTE_ARRAY' got 'Type.DOUBLE_ARRAY'
words [] False Wrong parameter type, expected 'Type.STRING_ARRAY' got 'Type.BYTE_ARRAY'
words [] True 
raises: Trying to set parameter 'given' to '['a']' of type 'STRING_ARRAY', expecting type 'BYTE_ARRAY': given
SEEN
