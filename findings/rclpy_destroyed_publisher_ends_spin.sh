#!/usr/bin/env bash
# Guess: destroy() of a thing of a node is harmless for all kinds of things, or for none: client and
#        service have the same warning in their docstrings as publisher and subscription ("Users
#        should not"), a timer has none.
# Seen:  after timer, client, service, guard condition or rate.destroy() the node goes on. After
#        publisher.destroy() or subscription.destroy() spin ends with InvalidHandle, whose message
#        names nothing, and so does every later spin of the node. It is their event handlers that
#        stay behind: without the default ones destroy() is harmless here, too, as
#        node.destroy_publisher() and destroy_subscription() always are.
# With:  ros-jazzy-rclpy 7.1.6, ros-jazzy-common-interfaces 5.3.6 (Python 3.11), 2026-11-29
#        (the same with ros-kilted-rclpy 9.1.2)
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" --quiet install ros-jazzy-rclpy==7.1.6 ros-jazzy-common-interfaces==5.3.6 \
  ros-jazzy-rmw-fastrtps-cpp==8.4.3
ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST "$work/venv/bin/python" - > "$work/seen" <<'PY'
import contextlib
import io
import itertools

import rclpy
from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.exceptions import InvalidHandle
from rclpy.executors import MultiThreadedExecutor, SingleThreadedExecutor
from rclpy.task import Future
from std_msgs.msg import Empty
from std_srvs.srv import Trigger

numbers = itertools.count()


def after(executor, make, destroy):
    """Destroy a new thing in a callback, and tell what two spins of the node come to."""
    node, ends, ticks = rclpy.create_node(f"works_{next(numbers)}"), [], []

    def tick():
        ticks.append(True)
        if len(ticks) == 2:
            destroy(node, thing)
        if len(ticks) % 5 == 0:
            enough.set_result(True)

    thing = make(node)
    node.create_timer(0.02, tick)
    executor.add_node(node)
    for _ in range(2):
        enough = Future()
        try:
            executor.spin_until_future_complete(enough, timeout_sec=60)
            ends.append("goes on" if enough.done() else "hangs")
        except InvalidHandle as error:
            ends.append(f"{type(error).__name__}: {error}")
    executor.remove_node(node)
    return ends[0] if ends[0] == ends[1] else ends


quiet = PublisherEventCallbacks(use_default_callbacks=False)
quiet_too = SubscriptionEventCallbacks(use_default_callbacks=False)
things = {
    "timer": lambda node: node.create_timer(0.02, lambda: None),
    "client": lambda node: node.create_client(Trigger, "ask"),
    "service": lambda node: node.create_service(Trigger, "ask", print),
    "guard condition": lambda node: node.create_guard_condition(print),
    "rate": lambda node: node.create_rate(50),
    "publisher": lambda node: node.create_publisher(Empty, "out", 1),
    "subscription": lambda node: node.create_subscription(Empty, "in", print, 1),
    "publisher without events": lambda node: node.create_publisher(
        Empty, "out", 1, event_callbacks=quiet
    ),
    "subscription without events": lambda node: node.create_subscription(
        Empty, "in", print, 1, event_callbacks=quiet_too
    ),
}
rclpy.init()
for kind in (SingleThreadedExecutor, MultiThreadedExecutor):
    print(kind.__name__)
    with contextlib.redirect_stderr(io.StringIO()):
        for name, make in things.items():
            print(f"  {name}:", after(kind(), make, lambda node, thing: thing.destroy()))
        for name in ("publisher", "subscription"):
            way = f"destroy_{name}"
            end = after(kind(), things[name], lambda node, thing: getattr(node, way)(thing))
            print(f"  node.{way}:", end)
PY
for kind in Single Multi; do cat <<SEEN; done | diff "$work/seen" - && echo "as it was"
${kind}ThreadedExecutor
  timer: goes on
  client: goes on
  service: goes on
  guard condition: goes on
  rate: goes on
  publisher: InvalidHandle: cannot use Destroyable because destruction was requested
  subscription: InvalidHandle: cannot use Destroyable because destruction was requested
  publisher without events: goes on
  subscription without events: goes on
  node.destroy_publisher: goes on
  node.destroy_subscription: goes on
SEEN
