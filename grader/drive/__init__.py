"""Drive any rclpy node in the mock robot, without grading it; look for worlds that it fails in."""

from grader.drive.moments import check_moments, print_moments, tables_of
from grader.drive.node import (
    arguments_of,
    drive_in,
    drive_node,
    read_env,
    read_keys,
    read_params_files,
    read_stdin,
    scenario_for,
)
from grader.drive.summary import IN_REPLAY, event_lines, print_summary, touched_of
from grader.trial.packages import unpacked

__all__ = [
    "IN_REPLAY",
    "arguments_of",
    "check_moments",
    "drive_in",
    "drive_node",
    "event_lines",
    "print_moments",
    "print_summary",
    "read_env",
    "read_keys",
    "read_params_files",
    "read_stdin",
    "scenario_for",
    "tables_of",
    "touched_of",
    "unpacked",
]
