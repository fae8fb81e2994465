#!/usr/bin/env bash
# Guess: a lifecycle publisher publishes while its node is active, and in no other state.
# Seen:  only its own on_activate and on_deactivate switch it. A node that is shut down while it is
#        active is finalized, and publishes as before; so does one that came back to unconfigured,
#        because its on_deactivate raised (of which nothing is printed), and an inactive one whose
#        on_activate called super().on_activate() first, as advised, and then found a FAILURE.
# With:  ros-jazzy-rclpy 7.1.6, ros-jazzy-common-interfaces 5.3.6 (Python 3.11), 2026-11-29
#        (the same with ros-kilted-rclpy 9.1.2)
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" --quiet install ros-jazzy-rclpy==7.1.6 ros-jazzy-common-interfaces==5.3.6 \
  ros-jazzy-rmw-fastrtps-cpp==8.4.3
ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST "$work/venv/bin/python" -u - > "$work/seen" 2>&1 <<'PY'
import time

import rclpy
from lifecycle_msgs.srv import GetState
from rclpy.lifecycle import LifecycleNode, TransitionCallbackReturn
from std_msgs.msg import String


class Motor(LifecycleNode):
    def __init__(self, name, fault):
        super().__init__(name)
        self.fault = fault
        self.turns = self.create_lifecycle_publisher(String, name, 10)
        self.always = self.create_publisher(String, name, 10)

    def on_activate(self, state):
        done = super().on_activate(state)
        return TransitionCallbackReturn.FAILURE if self.fault == "no power" else done

    def on_deactivate(self, state):
        if self.fault == "does not answer":
            raise RuntimeError(self.fault)
        return super().on_deactivate(state)


def state_of(node):
    """Ask the node itself, by its service's own callback."""
    client = ears.create_client(GetState, f"{node.get_name()}/get_state")
    client.wait_for_service(60)
    future = client.call_async(GetState.Request())
    while not future.done():
        rclpy.spin_once(node, timeout_sec=0.05)
        rclpy.spin_once(ears, timeout_sec=0.05)
    return future.result().current_state.label


rclpy.init()
ears = rclpy.create_node("ears")
for name, fault, steps in (
    ("quiet", "", ("configure", "activate", "deactivate", "shutdown")),
    ("gone", "", ("configure", "activate", "shutdown")),
    ("broken", "does not answer", ("configure", "activate", "deactivate")),
    ("refused", "no power", ("configure", "activate")),
):
    node, heard = Motor(name, fault), []
    ears.create_subscription(String, name, lambda said, to=heard: to.append(said.data), 10)
    while not (node.turns.get_subscription_count() and node.always.get_subscription_count()):
        time.sleep(0.01)
    results = [getattr(node, f"trigger_{step}")().name for step in steps]
    print(name, results[-1], state_of(node))
    node.turns.publish(String(data="turn"))
    node.always.publish(String(data="end"))
    waits_until = time.monotonic() + 60
    while "end" not in heard and time.monotonic() < waits_until:
        rclpy.spin_once(ears, timeout_sec=0.1)
    for _ in range(10):
        rclpy.spin_once(ears, timeout_sec=0.1)
    print("  heard:", sorted(heard, reverse=True))
PY
diff "$work/seen" - <<'SEEN' && echo "as it was"
quiet SUCCESS finalized
  heard: ['end']
gone SUCCESS finalized
  heard: ['turn', 'end']
broken ERROR unconfigured
  heard: ['turn', 'end']
refused FAILURE inactive
  heard: ['turn', 'end']
SEEN
