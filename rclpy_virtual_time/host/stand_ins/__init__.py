"""Packages of ROS that have no wheel, for nodes that need them: tf2_msgs and tf2_ros.

They are found last, so those of a ROS installation come before them. What they leave out is said
in their own docstrings; whatever else a node imports gets a hint (`grader/advice/hints.py`).
"""

from __future__ import annotations

import sys
from pathlib import Path

FOLDER = Path(__file__).parent
NAMES = frozenset(path.name for path in FOLDER.iterdir() if (path / "__init__.py").exists())


def offer() -> None:
    """Let a program import them."""
    if str(FOLDER) not in sys.path:
        sys.path.append(str(FOLDER))
