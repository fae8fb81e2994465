#!/usr/bin/env bash
# Guess: sys.exit() in a callback ends the program, whichever executor calls it, as any other
#        exception there ends the spin; or it says at least that it did not.
# Seen:  in a SingleThreadedExecutor spin raises SystemExit. In a MultiThreadedExecutor sys.exit()
#        ends the one callback, without a word, and the next callbacks come; the same with every
#        exception that is no Exception, as KeyboardInterrupt and asyncio's CancelledError. A
#        ValueError is raised by spin in both.
# With:  ros-jazzy-rclpy 7.1.6 (Python 3.11), 2026-11-29
#        (the same with ros-kilted-rclpy 9.1.2)
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" --quiet install ros-jazzy-rclpy==7.1.6 ros-jazzy-rmw-fastrtps-cpp==8.4.3
ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST "$work/venv/bin/python" - > "$work/seen" <<'PY'
import asyncio
import contextlib
import io
import itertools
import sys

import rclpy
from rclpy.executors import MultiThreadedExecutor, SingleThreadedExecutor
from rclpy.task import Future

numbers = itertools.count()


def leave():
    sys.exit(3)


def fail(error):
    raise error


def spin(executor, end):
    """Call a timer's callback that ends like this, five times at most, and tell what came."""
    calls, enough = [], Future()

    def tick():
        calls.append(end)
        if len(calls) == 5:
            enough.set_result(True)
        end()

    node = rclpy.create_node(f"works_{next(numbers)}")
    executor.add_node(node)
    node.create_timer(0.05, tick)
    try:
        executor.spin_until_future_complete(enough, timeout_sec=60)
        return "goes on" if enough.done() else "hangs"
    except BaseException as error:
        return f"spin raises {error!r}"
    finally:
        executor.remove_node(node)


rclpy.init()
for kind in (SingleThreadedExecutor, MultiThreadedExecutor):
    print(kind.__name__)
    for name, end in {
        "sys.exit(3)": leave,
        "KeyboardInterrupt": lambda: fail(KeyboardInterrupt()),
        "CancelledError": lambda: fail(asyncio.CancelledError()),
        "ValueError": lambda: fail(ValueError("no")),
    }.items():
        with contextlib.redirect_stderr(io.StringIO()) as said:
            what = spin(kind(), end)
        print(f"  {name}: {what}" + f", on stderr: {said.getvalue()!r}" * (what == "goes on"))
PY
diff "$work/seen" - <<'SEEN' && echo "as it was"
SingleThreadedExecutor
  sys.exit(3): spin raises SystemExit(3)
  KeyboardInterrupt: spin raises KeyboardInterrupt()
  CancelledError: spin raises CancelledError()
  ValueError: spin raises ValueError('no')
MultiThreadedExecutor
  sys.exit(3): goes on, on stderr: ''
  KeyboardInterrupt: goes on, on stderr: ''
  CancelledError: goes on, on stderr: ''
  ValueError: spin raises ValueError('no')
SEEN
