#!/usr/bin/env bash
# Guess: an exception in an action's callback ends the spin, as in every other callback, and the
#        goal fails; a goal whose function returned its result has succeeded; a result that is gone
#        is an error.
# Seen:  an exception in the execute callback is logged, and the node goes on (one in the goal
#        callback ends the spin). If succeed() was called before it, the client gets SUCCEEDED and
#        an empty result. A result returned without succeed() arrives, as ABORTED. And a client that
#        asks after result_timeout gets status UNKNOWN and an empty result, while its goal handle
#        says SUCCEEDED.
# With:  ros-jazzy-rclpy 7.1.6, ros-jazzy-test-msgs 2.0.3 (Python 3.11), 2026-11-29
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" --quiet install ros-jazzy-rclpy==7.1.6 ros-jazzy-test-msgs==2.0.3 \
  ros-jazzy-rmw-fastrtps-cpp==8.4.3
ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST "$work/venv/bin/python" - > "$work/seen" <<'PY'
import time

import rclpy
from action_msgs.msg import GoalStatus
from rclpy.action import ActionClient, ActionServer
from test_msgs.action import Fibonacci

NAMES = {
    getattr(GoalStatus, f"STATUS_{name}"): name for name in ("UNKNOWN", "SUCCEEDED", "ABORTED")
}


def sound(goal):
    goal.succeed()
    return Fibonacci.Result(sequence=[1, 2])


def fails(goal):
    raise ValueError("no way")


def succeeds_and_fails(goal):
    goal.succeed()
    raise ValueError("no way")


def forgets_to_succeed(goal):
    return Fibonacci.Result(sequence=[1, 2])


def waits_for(future):
    rclpy.spin_until_future_complete(node, future, timeout_sec=60)
    return future.result()


def ask(name, execute, wait=0.0, **options):
    server = ActionServer(node, Fibonacci, name, execute, **options)
    client = ActionClient(node, Fibonacci, name)
    client.wait_for_server(60)
    try:
        goal = waits_for(client.send_goal_async(Fibonacci.Goal(order=2)))
        end = time.monotonic() + wait
        while time.monotonic() < end:
            rclpy.spin_once(node, timeout_sec=0.1)
        answer = waits_for(goal.get_result_async())
        print(f"{name}: {NAMES[answer.status]} {list(answer.result.sequence)}", end="; ")
        print("the goal handle says", NAMES[goal.status])
    except ValueError as error:
        print(f"{name}: the spin ends, ValueError: {error}")
    client.destroy()
    server.destroy()


rclpy.init()
node = rclpy.create_node("works")
for execute in (sound, fails, succeeds_and_fails, forgets_to_succeed):
    ask(execute.__name__, execute)
ask("goal_callback_fails", sound, goal_callback=fails)
ask("asked_too_late", sound, wait=3.0, result_timeout=0.5)
PY
diff "$work/seen" - <<'SEEN' && echo "as it was"
sound: SUCCEEDED [1, 2]; the goal handle says SUCCEEDED
fails: ABORTED []; the goal handle says ABORTED
succeeds_and_fails: SUCCEEDED []; the goal handle says SUCCEEDED
forgets_to_succeed: ABORTED [1, 2]; the goal handle says ABORTED
goal_callback_fails: the spin ends, ValueError: no way
asked_too_late: UNKNOWN []; the goal handle says SUCCEEDED
SEEN
