#!/usr/bin/env bash
# Guess: rclpy's Future behaves as asyncio's or concurrent.futures': result() of one that is not
#        done raises or waits, a cancelled one is done and raises CancelledError, a second result is
#        an error.
# Seen:  result() of a future that is not done returns None, as a service without an answer would; a
#        cancelled one is not done(), and its result() is None, too; a second set_result replaces the
#        first; an exception in a done callback is a UserWarning, and set_result returns.
# With:  ros-jazzy-rclpy 7.1.6 (Python 3.11 to 3.13), 2026-11-28
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" --quiet install ros-jazzy-rclpy==7.1.6 ros-jazzy-rmw-fastrtps-cpp==8.4.3
"$work/venv/bin/python" - > "$work/seen" <<'PY'
import warnings

from rclpy.task import Future


def fails(future):
    raise ValueError("in the callback")


future = Future()
print("not done:", future.result(), future.exception())
future.cancel()
print("cancelled:", future.cancelled(), "done:", future.done(), "result:", future.result())
future = Future()
future.set_result(1)
future.set_result(2)
print("set twice:", future.result())
future = Future()
future.add_done_callback(fails)
with warnings.catch_warnings(record=True) as caught:
    warnings.simplefilter("always")
    future.set_result(3)
print("a callback failed:", future.result(), [each.category.__name__ for each in caught])
PY
diff "$work/seen" - <<'SEEN' && echo "as it was"
not done: None None
cancelled: True done: False result: None
set twice: 2
a callback failed: 3 ['UserWarning']
SEEN
