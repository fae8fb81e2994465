"""What changed since the last attempt, and the last grading: small files in the state folder.

It is for the student's eyes only: no grading depends on it, and no result file quotes it. Nothing
about it is ever an error: where it can't be read or written, nothing is said.
"""

import contextlib
import os
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import click
import msgspec

from grader.course.exercises import SOLUTIONS
from grader.course.submission import read_regular_file
from grader.grading.grading import Grading
from grader.grading.plugin import PASS, UNJUDGED

FOLDER, FILE = "rclpy-agents-course", "attempts.json"
LAST = "last.json"  # the newest grading, for `course why`
MAX_BYTES = 128 * 1024
MAX_LAST = 4 * 1024 * 1024
MAX_FILES = 60  # the oldest go
MAX_NAMES = 8  # of checks in a line

Passed = dict[str, bool]  # by check


class _History(msgspec.Struct):
    attempts: dict[str, Passed]  # by exercise and file, the newest last


def history() -> Path:
    """Return where attempts are remembered: the XDG state folder, or the system's own place.

    Raises OSError: this user has no home.
    """
    try:
        if sys.platform != "linux":
            return Path(click.get_app_dir(FOLDER), FILE)
        return (
            Path(os.environ.get("XDG_STATE_HOME") or "~/.local/state").expanduser() / FOLDER / FILE
        )
    except RuntimeError as error:
        raise OSError(str(error)) from None


def attempts() -> dict[tuple[str, Path], Passed]:
    """Return what passed last, by exercise (its slug) and file, the newest last."""
    with contextlib.suppress(OSError):
        parts = ((key.partition(":"), passed) for key, passed in _read(history()).items())
        return {(slug, Path(file)): passed for (slug, _, file), passed in parts}
    return {}


def since_last(grading: Grading, file: Path) -> str:
    """Return what changed after the last grading of `file`, and remember this grading.

    "+20: stop_zone, slow_zone"; "" if nothing did, or if this is the first time. Checks that could
    not be judged, now or then, are left out.
    """
    if file.resolve().is_relative_to(SOLUTIONS):  # nobody's attempt
        return ""
    file = file / grading.exercise.files[0] if file.is_dir() else file
    key = f"{grading.exercise.slug}:{file.resolve()}"
    judged = [check for check in grading.checks if check.outcome not in UNJUDGED]
    now = {check.id: check.outcome == PASS for check in judged}
    before: Passed = {}
    with contextlib.suppress(OSError):
        path = history()
        known = _read(path)
        before = known.pop(key, {})
        known[key] = {**before, **now}  # with --only some checks are not run
        _write(path, dict(list(known.items())[-MAX_FILES:]))
    points = {check.id: check.max_points for check in judged}
    gained = [name for name in now if now[name] and before.get(name) is False]
    lost = [name for name in now if not now[name] and before.get(name)]
    return "; ".join(
        f"{sign}{sum(points[name] for name in names)}: {_names(names)}"
        for sign, names in (("+", gained), ("-", lost))
        if names
    )


def keep(result: Mapping[str, Any]) -> None:
    """Remember a grading (its JSON object), in place of the one before."""
    with contextlib.suppress(OSError, ValueError, TypeError):
        content = msgspec.json.encode(result)
        if len(content) <= MAX_LAST:
            replace(history().with_name(LAST), content)


def last_grading() -> dict[str, Any] | None:
    """Return the newest grading's JSON object; None if there is none that can be read."""
    with contextlib.suppress(OSError, ValueError, RecursionError):
        content = read_regular_file(history().with_name(LAST), MAX_LAST)
        return msgspec.json.decode(content, type=dict[str, Any])
    return None


def _names(names: list[str]) -> str:
    more = len(names) - MAX_NAMES
    return ", ".join(names[:MAX_NAMES]) + (f" and {more} more" if more > 0 else "")


def _read(path: Path) -> dict[str, Passed]:
    try:
        content = read_regular_file(path, MAX_BYTES)
        return msgspec.json.decode(content, type=_History).attempts
    except (OSError, ValueError, RecursionError):
        return {}


def _write(path: Path, attempts: dict[str, Passed]) -> None:
    """Replace the file, whatever it is; another grading at the same time costs one of the two.

    Raises OSError: it can't be written.
    """
    content = msgspec.json.encode(_History(attempts))
    if len(content) <= MAX_BYTES:
        replace(path, content)


def replace(path: Path, content: bytes) -> None:
    """Write a small file, replacing any; make its folder.

    Raises OSError: it can't be written.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    fd, name = tempfile.mkstemp(prefix=path.name, dir=path.parent)
    try:
        with os.fdopen(fd, "wb") as file:
            file.write(content)
        Path(name).replace(path)
    except OSError:
        Path(name).unlink(missing_ok=True)
        raise
