#!/usr/bin/env bash
# Guess: a context that is shut down by Ctrl-C and one that rclpy.shutdown() shuts down leave a node in
#        the same state; what raises after the one raises after the other.
# Seen:  in Kilted shutdown() and try_shutdown() destroy every node of the context, so even get_name()
#        raises InvalidHandle afterwards, and a publish() that too. After Ctrl-C the nodes live on:
#        get_name() answers, and publish() raises RCLError. try_shutdown() then does nothing, and
#        shutdown() destroys them without a word (in Jazzy it raised here, and destroyed no node).
# With:  ros-kilted-rclpy 9.1.2 (Python 3.11 to 3.13), 2026-11-28
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" --quiet install ros-kilted-rclpy==9.1.2 ros-kilted-common-interfaces==5.5.1 \
  ros-kilted-rmw-fastrtps-cpp==9.3.3
cat > "$work/node.py" <<'PY'
import os
import signal
import sys
import threading
import time

import rclpy
from std_msgs.msg import String


def tell(what, call):
    try:
        print(what, call())
    except Exception as error:
        print(what, type(error).__name__)


def look():
    tell("  name:", node.get_name)
    tell("  publish:", lambda: publisher.publish(String()))


rclpy.init()
node = rclpy.create_node("speaks")
publisher = node.create_publisher(String, "x", 1)
if "Ctrl-C" in sys.argv:
    threading.Timer(0.2, os.kill, (os.getpid(), signal.SIGINT)).start()
    try:
        rclpy.spin(node)
    except KeyboardInterrupt:
        print("Ctrl-C")
    while rclpy.ok():  # the signal's thread shuts it down
        time.sleep(0.01)
    look()
tell(sys.argv[1], getattr(rclpy, sys.argv[1]))
look()
PY
for how in try_shutdown shutdown "try_shutdown Ctrl-C" "shutdown Ctrl-C"; do
  # shellcheck disable=SC2086
  ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST "$work/venv/bin/python" -u "$work/node.py" $how
done > "$work/seen"
diff "$work/seen" - <<'SEEN' && echo "as it was"
try_shutdown None
  name: InvalidHandle
  publish: InvalidHandle
shutdown None
  name: InvalidHandle
  publish: InvalidHandle
Ctrl-C
  name: speaks
  publish: RCLError
try_shutdown None
  name: speaks
  publish: RCLError
Ctrl-C
  name: speaks
  publish: RCLError
shutdown None
  name: InvalidHandle
  publish: InvalidHandle
SEEN
