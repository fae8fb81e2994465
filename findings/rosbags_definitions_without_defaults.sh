#!/usr/bin/env bash
# Guess: a message's definition that rosbags gives, and writes into a bag, is the one that ROS has;
#        and what is not set of a pose is what ROS says, w = 1.
# Seen:  the defaults are gone: "float64 w 1" becomes "float64 w", its constants stay. So a writer
#        that takes its definitions from rosbags (mcap-ros2-support needs their text) makes
#        orientations of 0, 0, 0, 0, which are no rotation, where the same dictionary with ROS's
#        text makes w = 1. The hash is the same for both. rosbags' own classes have no defaults at
#        all. And a word that is no field of the message is dropped in silence.
# With:  rosbags 0.11.9, mcap-ros2-support 0.6.0, mcap 1.6.0 (Python 3.11), 2026-11-29
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" --quiet install rosbags==0.11.9 mcap-ros2-support==0.6.0 mcap==1.6.0
"$work/venv/bin/python" - > "$work/seen" <<'PY'
from io import BytesIO

from mcap_ros2.reader import read_ros2_messages
from mcap_ros2.writer import Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

KIND = "geometry_msgs/msg/Quaternion"
ROS = "uint8 SIZE=4\nfloat64 x 0\nfloat64 y 0\nfloat64 z 0\nfloat64 w 1\n"


def again(definition, message):
    file = BytesIO()
    writer = Writer(file)
    schema = writer.register_msgdef(KIND, definition)
    writer.write_message("/turn", schema, message)
    writer.finish()
    file.seek(0)
    (read,) = read_ros2_messages(file)
    return read.ros_msg


store = get_typestore(Stores.EMPTY)
store.register(get_types_from_msg(ROS, KIND))
definition, _ = store.generate_msgdef(KIND, ros_version=2)
bare = get_typestore(Stores.EMPTY)
bare.register(get_types_from_msg(ROS.replace(" 0", "").replace(" 1", ""), KIND))
print(definition.splitlines(), store.hash_rihs01(KIND) == bare.hash_rihs01(KIND))
jazzy, _ = get_typestore(Stores.ROS2_JAZZY).generate_msgdef(KIND, ros_version=2)
print(jazzy.splitlines())
for message in ({}, {"z": 1.0, "W": 0.5}):
    print(message, "by ROS's text:", again(ROS, message))
    print(message, "by rosbags':", again(jazzy, message))
try:
    store.types[KIND]()
except TypeError as error:
    print(str(error).partition("() ")[2])
PY
diff "$work/seen" - <<'SEEN' && echo "as it was"
['uint8 SIZE=4', 'float64 x', 'float64 y', 'float64 z', 'float64 w'] True
['float64 x', 'float64 y', 'float64 z', 'float64 w']
{} by ROS's text: Quaternion(x=0.0, y=0.0, z=0.0, w=1.0)
{} by rosbags': Quaternion(x=0.0, y=0.0, z=0.0, w=0.0)
{'z': 1.0, 'W': 0.5} by ROS's text: Quaternion(x=0.0, y=0.0, z=1.0, w=1.0)
{'z': 1.0, 'W': 0.5} by rosbags': Quaternion(x=0.0, y=0.0, z=1.0, w=0.0)
missing 4 required positional arguments: 'x', 'y', 'z', and 'w'
SEEN
