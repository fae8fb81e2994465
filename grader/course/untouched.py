"""Whether submitted files are still the skeleton, and the first task there."""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import cache

from grader.course.exercises import all_exercises

_TASK = re.compile(r"(?m)^1\. \*\*(?P<title>.+?)\.?\*\*")  # of a README


def untouched(files: Mapping[str, bytes]) -> str:
    """Say which files are still the skeleton; "" if none is.

    Parameters
    ----------
    files
        The submission's own files, by name; a node may be called as it likes.
    """
    known = {name: _skeletons().get(bare(content)) for name, content in files.items()}
    left = [name for name, task in known.items() if task is not None]
    if not left:
        return ""
    if len(left) < len(files):
        return f"Still the skeleton: {', '.join(left)}."
    return f"This is still the skeleton: task 1 is “{known[left[0]]}”."


@cache
def _skeletons() -> dict[bytes, str]:
    """Return the first task of each exercise, by the text of its skeletons."""
    found = {}
    for exercise in all_exercises():
        task = _TASK.search((exercise.folder / "README.md").read_text("utf-8"))
        for name in exercise.files:
            if task and (exercise.folder / name).is_file():
                found[bare((exercise.folder / name).read_bytes())] = task["title"]
    return found


def bare(content: bytes) -> bytes:
    return b"\n".join(line.rstrip() for line in content.strip().splitlines())
