"""Try whether nodes run on this machine: a skeleton is graded, and libraries are imported."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from grader.course import installed
from grader.course.exercises import all_exercises
from grader.errors import GraderError
from grader.grading.handed_in import grade_files
from grader.launchers import fork_server
from rclpy_virtual_time import (
    Ended,
    Excess,
    ForkServer,
    HostDied,
    HostForged,
    HostHung,
    Link,
    fresh_folder,
)

DIED = "the node died"  # a skeleton doesn't, unless ROS can't start here
IMPORT_LIMIT = 120.0  # [s] from a cold disk
# What each of them does once it works: threads, and some memory.
WORK = """
import threading
threads = [threading.Thread(target=bytearray, args=(1 << 20,)) for _ in range(16)]
for thread in threads: thread.start()
"""


def why_none_runs() -> str:
    """Return why not even a skeleton runs here; "" if a skeleton runs."""
    exercise = all_exercises()[0]
    files = {name: (exercise.folder / name).read_bytes() for name in exercise.files}
    try:
        grading = grade_files(exercise, files, trust=True)
    except GraderError as error:
        return str(error)
    failed = [
        check
        for check in grading["checks"]
        if check["outcome"] == "error" or DIED in (check["message"] or "")
    ]
    return f"{failed[0]['title']} {failed[0]['message']}" if failed else ""


def imports_that_fail() -> Iterator[str]:
    """Import what exercises need, as a node does and under its limits; say what can't be."""
    with fork_server() as server:
        for exercise in all_exercises():
            names = [name for name in exercise.libraries if _is_installed(name)]
            if names and (problem := _import(server, names)):
                yield f"Exercise {exercise.number} needs {', '.join(names)} in one node: {problem}"


def _is_installed(name: str) -> bool:
    return not installed.why_not([name.partition(".")[0]])


def _import(server: ForkServer, names: list[str]) -> str:
    """Return why a host can't import these modules; "" if it can."""
    with fresh_folder() as folder:
        file = folder / "imports.py"
        file.write_text("".join(f"import {name}\n" for name in names) + WORK, "utf-8")
        with server.workshop.host(folder) as link:
            return _answer(link, file)


def _answer(link: Link, file: Path) -> str:
    try:
        answer, _ = link.run_script(file, (), 0, IMPORT_LIMIT)
    except HostHung:
        return f"it was not done after {IMPORT_LIMIT:.0f} s."
    except (HostDied, HostForged, Excess) as error:
        said = [line.text for line in link.log()]
        return f"the process ended ({error}). {' '.join(said[-1:])}"
    if not isinstance(answer, Ended) or answer.kind != "returned":
        return getattr(answer, "text", "it did not end as a program does")
    return ""
