#!/usr/bin/env bash
# Guess: callbacks of one MutuallyExclusiveCallbackGroup (the node's own group, if none is named)
#        are called one at a time, and where there is too much to do they take turns; and a
#        MultiThreadedExecutor is at least as fair there as a SingleThreadedExecutor.
# Seen:  in a SingleThreadedExecutor they take turns. A MultiThreadedExecutor looks anew after every
#        callback and takes the first that is ready, timers before messages. So if the callback of
#        the node's first timer takes longer than the period, that timer is called all the time, the
#        second one and the subscription next to never, and nothing is said. As soon as the
#        callback is quick, the messages come. With a ReentrantCallbackGroup all have their share.
# With:  ros-jazzy-rclpy 7.1.6, ros-jazzy-common-interfaces 5.3.6 (Python 3.11), 2026-11-29
#        (the same with ros-kilted-rclpy 9.1.2)
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" --quiet install ros-jazzy-rclpy==7.1.6 ros-jazzy-common-interfaces==5.3.6 \
  ros-jazzy-rmw-fastrtps-cpp==8.4.3
ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST "$work/venv/bin/python" - > "$work/seen" <<'PY'
import time

import rclpy
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor, SingleThreadedExecutor
from rclpy.task import Future
from std_msgs.msg import Empty

CALLS = 15  # a fair share of three is 5 of them


def share(name):
    count = calls[:CALLS].count(name)
    return "nearly all" if count > 10 else "few or none" if count < 3 else "its share"


def works(name):
    """Return a callback that takes five times the timers' period, till the calls suffice."""

    def callback(_=None):
        if not enough.done():
            calls.append(name)
            time.sleep(0.05)
            if len(calls) >= CALLS:
                enough.set_result(True)
        elif name == "message":
            heard.set_result(True)

    return callback


rclpy.init()
for number, (executor, group) in enumerate(
    (
        (SingleThreadedExecutor(), None),
        (MultiThreadedExecutor(4), None),
        (SingleThreadedExecutor(), ReentrantCallbackGroup()),
        (MultiThreadedExecutor(4), ReentrantCallbackGroup()),
    )
):
    node = rclpy.create_node(f"works_{number}")
    calls, enough, heard = [], Future(), Future()
    publisher = node.create_publisher(Empty, f"in_{number}", 2 * CALLS)
    node.create_subscription(
        Empty, f"in_{number}", works("message"), 2 * CALLS, callback_group=group
    )
    node.create_timer(0.01, works("first"), callback_group=group)
    node.create_timer(0.01, works("second"), callback_group=group)
    end = time.monotonic() + 60
    while not publisher.get_subscription_count():
        assert time.monotonic() < end
    for _ in range(2 * CALLS):
        publisher.publish(Empty())
    time.sleep(0.2)  # the messages have come, and both timers are overdue
    executor.add_node(node)
    print(type(executor).__name__, "Reentrant" if group else "MutuallyExclusive")
    executor.spin_until_future_complete(enough, timeout_sec=60)
    print("  " + ", ".join(f"{name}: {share(name)}" for name in ("first", "second", "message")))
    executor.spin_until_future_complete(heard, timeout_sec=60)
    print("  all quick, and a message comes:", heard.done())
    executor.remove_node(node)
PY
diff "$work/seen" - <<'SEEN' && echo "as it was"
SingleThreadedExecutor MutuallyExclusive
  first: its share, second: its share, message: its share
  all quick, and a message comes: True
MultiThreadedExecutor MutuallyExclusive
  first: nearly all, second: few or none, message: few or none
  all quick, and a message comes: True
SingleThreadedExecutor Reentrant
  first: its share, second: its share, message: its share
  all quick, and a message comes: True
MultiThreadedExecutor Reentrant
  first: its share, second: its share, message: its share
  all quick, and a message comes: True
SEEN
