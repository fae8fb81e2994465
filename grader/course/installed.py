"""Which optional libraries are installed where the grader runs; none is imported to find out."""

from __future__ import annotations

import importlib.util
import platform
from collections.abc import Iterable

from grader.errors import GraderError
from rclpy_virtual_time import RosEnvironment

COURSE = "rclpy-agents-course"
OPTIONAL = {  # module: its usual name, and its distribution
    "sklearn": ("scikit-learn", "scikit-learn"),
    "onnx": ("onnx", "onnx"),
    "onnxruntime": ("onnxruntime", "onnxruntime"),
    "skl2onnx": ("skl2onnx", "skl2onnx"),
    "torch": ("PyTorch", "torch"),
    "keras": ("Keras", "keras"),
}


def why_not(modules: Iterable[str]) -> str:
    """Name the missing libraries and how to install them; empty if none is missing.

    Raises GraderError: a check requires a library that is not one of the optional ones.
    """
    missing = [module for module in modules if not _is_installed(module)]
    if not missing:
        return ""
    names = [OPTIONAL[module][0] for module in missing]
    verb = "is" if len(names) == 1 else "are"
    # by their own names: nobody owns the course's on the package index, so anybody could
    command = f"pip install {' '.join(OPTIONAL[module][1] for module in missing)}"
    return f"skipped: {' and '.join(names)} {verb} not installed here; {command}"


def _is_installed(module: str) -> bool:
    if module not in OPTIONAL:
        raise GraderError(f"a check requires {module!r}; there are: {', '.join(OPTIONAL)}")
    spec = importlib.util.find_spec(module)
    return spec is not None and spec.origin is not None  # None: some folder of that name


def never_run() -> str:
    """Say that the course is untried on such a system; "" if it has run there."""
    if RosEnvironment.is_tried():
        return ""
    here = f"{platform.system()} on {platform.machine()}"
    return f"The course has never been run on a real {here} yet. Please tell what you see."
