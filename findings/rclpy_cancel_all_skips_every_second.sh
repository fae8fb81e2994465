#!/usr/bin/env bash
# Guess: where a client asks to cancel all goals, the action server asks its cancel_callback about
#        each, and a callback that refuses leaves goals_canceling empty.
# Seen:  a refused goal is taken out of the very list that is gone through, so after each refusal
#        the next goal is passed over: of four, two are never asked about, and just these stand in
#        the answer as being cancelled. They go on, and is_cancel_requested is False. A server
#        without a cancel_callback, which refuses everything, answers like that, too.
# With:  ros-jazzy-rclpy 7.1.6, ros-jazzy-test-msgs 2.0.3 (Python 3.11), 2026-11-29
#        (the same with ros-kilted-rclpy 9.1.2)
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" --quiet install ros-jazzy-rclpy==7.1.6 ros-jazzy-test-msgs==2.0.3 \
  ros-jazzy-rmw-fastrtps-cpp==8.4.3
ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST "$work/venv/bin/python" - > "$work/seen" <<'PY'
import rclpy
from action_msgs.srv import CancelGoal
from rclpy.action import ActionClient, ActionServer, CancelResponse
from test_msgs.action import Fibonacci


def refuse(goal):
    asked.append(goal.request.order)
    return CancelResponse.REJECT


def answer_to(call, request):
    future = call(request)
    rclpy.spin_until_future_complete(node, future, timeout_sec=60)
    return future.result()


rclpy.init()
for options in ({"cancel_callback": refuse}, {}):
    node, goals, asked = rclpy.create_node("works"), [], []
    options["handle_accepted_callback"] = goals.append  # they are kept, and none is begun
    server = ActionServer(node, Fibonacci, "work", print, **options)
    client = ActionClient(node, Fibonacci, "work")
    cancel = node.create_client(CancelGoal, "work/_action/cancel_goal")
    client.wait_for_server(60)
    cancel.wait_for_service(60)
    for order in range(4):
        answer_to(client.send_goal_async, Fibonacci.Goal(order=order))
    answer = answer_to(cancel.call_async, CancelGoal.Request())  # no id, no time: all goals
    orders = {bytes(goal.goal_id.uuid): goal.request.order for goal in goals}
    print("goals:", sorted(orders.values()), "asked about:", asked)
    print("  canceling:", [orders[bytes(info.goal_id.uuid)] for info in answer.goals_canceling])
    print("  requested:", [goal.is_cancel_requested for goal in goals])
    server.destroy()
    client.destroy()
    node.destroy_node()
PY
diff "$work/seen" - <<'SEEN' && echo "as it was"
goals: [0, 1, 2, 3] asked about: [0, 2]
  canceling: [1, 3]
  requested: [False, False, False, False]
goals: [0, 1, 2, 3] asked about: []
  canceling: [1, 3]
  requested: [False, False, False, False]
SEEN
