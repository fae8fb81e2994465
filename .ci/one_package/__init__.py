"""The course as one package: folders as they are in its repository, found when it is imported.

The names of the folders (`sim`, `grader`, `exercises`) are too general for everybody's
site-packages. Here they are inside of this package, and only a process that asks for the course can
import them: the command `course`, and whoever imports `rclpy_agents_course`.
"""

from __future__ import annotations

import sys
from pathlib import Path

FOLDER = Path(__file__).resolve().parent

if str(FOLDER) not in sys.path:
    sys.path.append(str(FOLDER))  # behind all others: somebody's own `sim` stays theirs


def main() -> None:
    """Be the command `course`: in its own process the course's names come first."""
    sys.path.remove(str(FOLDER))
    sys.path.insert(0, str(FOLDER))
    from grader.cli import main as course  # noqa: PLC0415

    course()
