"""What this computer is for the course: are there wheels of ROS 2 for it, was the course run on it?

It needs nothing that only Linux has.
"""

from __future__ import annotations

import contextlib
import importlib.metadata
import platform
import sys
from collections.abc import Mapping

EXTRAS: Mapping[str, tuple[str, ...]] = {  # what it is for: distributions
    "exercise 2, 5, 6, 8 and 9 (extra `ml`)": ("scikit-learn", "onnxruntime", "onnx", "skl2onnx"),
    "PyTorch and Keras in exercise 8 (extra `deep`)": ("torch", "keras"),
    "grading on a cluster (extra `cluster`)": ("distributed",),
    "the desk (extra `desk`)": ("tornado",),
    "notebooks (extra `notebooks`)": ("jupyterlab", "nbgrader"),
}
WHEELS_BEFORE = (3, 14)  # a Python for which there are none any more


def is_tried() -> bool:
    """Return whether the course has been run on such a system: Linux on x86_64."""
    return sys.platform == "linux" and platform.machine() in ("x86_64", "AMD64")


def has_ros_wheels() -> bool:
    """Return whether PyPI has the real ROS 2 for this system and this Python."""
    return is_tried() and sys.version_info < WHEELS_BEFORE


def name() -> str:
    """Say what this is: Python, system, processor."""
    return f"{platform.python_version()} on {platform.platform(terse=True)} ({platform.machine()})"


def never_run() -> str:
    """Say that nobody has run the course on such a system yet; "" if somebody has."""
    if is_tried():
        return ""
    system = f"{platform.system()} on {platform.machine()}"
    return f"The course has never been run on {system} yet. Please tell what you see."


def missing_extras() -> Mapping[str, tuple[str, ...]]:
    """Return what each extra is for, and which of its distributions are missing."""
    return {what: tuple(filter(_is_missing, names)) for what, names in EXTRAS.items()}


def _is_missing(distribution: str) -> bool:
    with contextlib.suppress(importlib.metadata.PackageNotFoundError):
        importlib.metadata.version(distribution)
        return False
    return True
