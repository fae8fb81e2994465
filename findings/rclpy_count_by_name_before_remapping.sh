#!/usr/bin/env bash
# Guess: where a node's /cmd_vel is remapped, all of its own questions about "cmd_vel" mean the new
#        name, or none does.
# Seen:  resolve_topic_name and get_publishers_info_by_topic apply the remapping, count_publishers
#        and count_subscribers don't: they count 0 beside a publisher of this very node, so a loop
#        that waits for somebody to listen waits for ever. client.srv_name is the old name, a
#        service's too; publisher.topic_name is the new one.
# With:  ros-jazzy-rclpy 7.1.6, ros-jazzy-common-interfaces 5.3.6 (Python 3.11), 2026-11-29
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" --quiet install ros-jazzy-rclpy==7.1.6 ros-jazzy-common-interfaces==5.3.6 \
  ros-jazzy-rmw-fastrtps-cpp==8.4.3
ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST "$work/venv/bin/python" - > "$work/seen" <<'PY'
import time

import rclpy
from std_msgs.msg import Empty
from std_srvs.srv import Trigger

rclpy.init(args=["--ros-args", "-r", "cmd_vel:=drive", "-r", "ask:=asked"])
node = rclpy.create_node("robot")
publisher = node.create_publisher(Empty, "cmd_vel", 1)
node.create_subscription(Empty, "cmd_vel", print, 1)
service = node.create_service(Trigger, "ask", print)
client = node.create_client(Trigger, "ask")
end = time.monotonic() + 60
while not (node.count_subscribers("drive") and node.count_services("asked")):
    assert time.monotonic() < end
print("publisher:", publisher.topic_name, "resolved:", node.resolve_topic_name("cmd_vel"))
for name in ("cmd_vel", "drive"):
    print(f"{name}: publishers {node.count_publishers(name)}", end=", ")
    print(f"subscribers {node.count_subscribers(name)}", end=", ")
    print(f"info of publishers {len(node.get_publishers_info_by_topic(name))}")
print("client:", client.srv_name, client.wait_for_service(60), "service:", service.srv_name)
for name in ("ask", "asked"):
    print(f"{name}: services {node.count_services(name)}, clients {node.count_clients(name)}")
PY
diff "$work/seen" - <<'SEEN' && echo "as it was"
publisher: /drive resolved: /drive
cmd_vel: publishers 0, subscribers 0, info of publishers 1
drive: publishers 1, subscribers 1, info of publishers 1
client: ask True service: ask
ask: services 0, clients 0
asked: services 1, clients 1
SEEN
