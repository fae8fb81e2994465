#!/usr/bin/env bash
# Guess: logger.info(text, once=True) prints each text once.
# Seen:  what is counted is the line of source that logs, for each logger, and not the text. A helper
#        function that a node logs through prints the node's first text, and never another; the same
#        with throttle_duration_sec. And a line that logs with another severity the second time
#        (getattr(logger, level)(…)) raises ValueError.
# With:  ros-jazzy-rclpy 7.1.6 (Python 3.11 to 3.13), 2026-11-28
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" --quiet install ros-jazzy-rclpy==7.1.6 ros-jazzy-rmw-fastrtps-cpp==8.4.3
RCUTILS_CONSOLE_OUTPUT_FORMAT='{name}: {message}' RCUTILS_LOGGING_USE_STDOUT=1 \
  "$work/venv/bin/python" -u - > "$work/seen" <<'PY'
from rclpy.logging import get_logger


def once(logger, text):
    logger.info(text, once=True)


def seldom(logger, text):
    logger.info(text, throttle_duration_sec=3600.0)


left, right = get_logger("left"), get_logger("right")
for log in (once, seldom):
    log(left, f"{log.__name__} one")
    log(left, f"{log.__name__} two")
    log(right, f"{log.__name__} three")
for level in ("info", "error"):
    try:
        getattr(left, level)(f"at {level}")
    except ValueError as error:
        print(error, flush=True)
PY
diff "$work/seen" - <<'SEEN' && echo "as it was"
left: once one
right: once three
left: seldom one
right: seldom three
left: at info
Logger severity cannot be changed between calls.
SEEN
