"""What changed since the last attempt: a small file beside the student's knows what passed.

It is for the student's eyes only: no grading depends on it, and no result file quotes it. Nothing
about it is ever an error: where it can't be read or written, nothing is said.
"""

from __future__ import annotations

import contextlib
import os
import tempfile
from pathlib import Path

import msgspec

from grader.course.exercises import SOLUTIONS
from grader.course.submission import read_regular_file
from grader.grading.grading import Grading
from grader.grading.plugin import PASS, UNJUDGED

FILE = ".course-attempts.json"
MAX_BYTES = 64 * 1024
MAX_FILES = 20  # of one folder; the oldest go
MAX_NAMES = 8  # of checks in a line


Passed = dict[str, bool]  # by check


class _History(msgspec.Struct):
    attempts: dict[str, Passed]  # by exercise and file, the newest last


def since_last(grading: Grading, file: Path) -> str:
    """Return what changed since `file` was graded last, and remember how it is now.

    "+20: stop_zone, slow_zone"; "" if nothing did, or if this is the first time. Checks that could
    not be judged, now or then, are left out.
    """
    if file.resolve().is_relative_to(SOLUTIONS):  # nobody's attempt
        return ""
    folder, name = (file, grading.exercise.files[0]) if file.is_dir() else (file.parent, file.name)
    path, key = folder / FILE, f"{grading.exercise.slug}/{name}"
    judged = [check for check in grading.checks if check.outcome not in UNJUDGED]
    now = {check.id: check.outcome == PASS for check in judged}
    attempts = _read(path)
    before = attempts.pop(key, {})
    attempts[key] = {**before, **now}  # with --only some checks are not run
    _write(path, dict(list(attempts.items())[-MAX_FILES:]))
    points = {check.id: check.max_points for check in judged}
    gained = [name for name in now if now[name] and before.get(name) is False]
    lost = [name for name in now if not now[name] and before.get(name)]
    return "; ".join(
        f"{sign}{sum(points[name] for name in names)}: {_names(names)}"
        for sign, names in (("+", gained), ("-", lost))
        if names
    )


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
    """Replace the file, whatever it is; another grading at the same time costs one of the two."""
    content = msgspec.json.encode(_History(attempts))
    if len(content) > MAX_BYTES:
        return
    with contextlib.suppress(OSError):
        fd, name = tempfile.mkstemp(prefix=FILE, dir=path.parent)
        try:
            with os.fdopen(fd, "wb") as file:
                file.write(content)
            Path(name).replace(path)
        except OSError:
            Path(name).unlink(missing_ok=True)
