"""Loggers: levels by name, and lines on stderr (rcutils/logging.c, Jazzy)."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from . import machine

if TYPE_CHECKING:
    from .arguments import Arguments

NAMES = {10: "DEBUG", 20: "INFO", 30: "WARN", 40: "ERROR", 50: "FATAL"}
INFO = 20
FORMAT = "[{severity}] [{time}] [{name}]: {message}"

_levels: dict[str, int] = {"": INFO}
_to_stderr = True


def configure(arguments: Arguments) -> None:
    """Take the levels of a command line."""
    global _to_stderr  # noqa: PLW0603  (rcutils has one logging system for each process)
    _levels.update(arguments.levels)
    _to_stderr = arguments.stderr


def get_logger_level(name: str) -> int:
    """Return the level that was set for a logger; 0 if none was."""
    return _levels.get(name, 0)


def get_logger_effective_level(name: str) -> int:
    """Return the level of a logger, or of the nearest one above it."""
    while name:
        if level := _levels.get(name):
            return level
        name = name.rpartition(".")[0]
    return _levels.get("") or INFO


def clear() -> None:
    """Forget all levels that were set."""
    _levels.clear()
    _levels[""] = INFO


def logger_is_enabled_for(name: str, severity: int) -> bool:
    """Return whether a logger writes lines of this severity."""
    return severity >= get_logger_effective_level(name)


def set_logger_level(name: str, level: int, detailed_error: bool = False) -> None:
    """Set the level of a logger; "" for all."""
    _levels[name] = int(level) or (0 if name else INFO)


def severity_level_from_string(text: str) -> int:
    """Return a severity by its name.

    Raises RuntimeError: there is none of that name.
    """
    for severity, name in {0: "UNSET", **NAMES}.items():
        if name == text.upper():
            return severity
    raise RuntimeError(f"failed to determine severity level of '{text}'")


def log(severity: int, name: str, message: str, function: str, file: str, line: int) -> None:
    """Write a line, if the logger writes such lines."""
    if not _to_stderr or not logger_is_enabled_for(name, severity):
        return
    now = machine.wall_ns()
    values = {
        "severity": NAMES.get(int(severity), "UNSET"),
        "time": f"{now // 10**9}.{now % 10**9:09}",
        "time_as_nanoseconds": str(now),
        "name": name,
        "function_name": function,
        "file_name": file,
        "line_number": str(line),
        "message": message,
    }
    form = os.environ.get("RCUTILS_CONSOLE_OUTPUT_FORMAT") or FORMAT
    os.write(2, f"{_filled(form, values)}\n".encode("utf-8", "replace"))


def _filled(form: str, values: dict[str, str]) -> str:
    """Fill in a format; what comes from a node is not looked at again."""
    parts = []
    while form:
        before, brace, rest = form.partition("{")
        word, closing, after = rest.partition("}")
        parts.append(before)
        if not brace:
            break
        parts.append(values[word] if closing and word in values else "{")
        form = after if closing and word in values else rest
    return "".join(parts)


def get_separator_string() -> str:
    """Return what stands between the name of a logger and that of its child."""
    return "."


def get_logging_directory() -> str:
    """Return where log files would go; none are written."""
    home = os.environ.get("ROS_HOME") or os.path.join("~", ".ros")
    folder = os.environ.get("ROS_LOG_DIR") or os.path.join(home, "log")
    return os.path.expanduser(folder)  # noqa: PTH111  (text, as rcl returns it)
