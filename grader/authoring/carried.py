"""The course's wheel in a release: beside the notebooks, or at an address that they are told.

Nobody has to trust a package index for the course itself, where anybody could own its name.
"""

import tomllib
from collections.abc import Mapping
from pathlib import Path

from grader.authoring.handouts import NOTEBOOKS
from grader.course.exercises import ROOT
from grader.notebook.bootstrap import with_address

BUILD = "run `make wheel` first, then release again"
# What the wheel is made of
PACKED = ("grader", "sim", "exercises", "rclpy_virtual_time", "rclpy_portable")


def built_wheel(root: Path = ROOT) -> Path | None:
    """Return the wheel of this version that `make wheel` built, if it did."""
    project = tomllib.loads((root / "pyproject.toml").read_text("utf-8"))["project"]
    name = project["name"].replace("-", "_")
    wheel = root / "dist" / f"{name}-{project['version']}-py3-none-any.whl"
    return wheel if wheel.is_file() else None


def what_lacks(wheel: Path | None, source: str, root: Path = ROOT) -> str:
    """Say what notebooks will lack that are released with this wheel; empty if nothing."""
    if wheel is None:
        return "" if source else f"no wheel is in dist, so the notebooks will ask for it; {BUILD}"
    files = (file for room in PACKED for file in (root / room).rglob("*.py"))
    changed = max((file.stat().st_mtime for file in files), default=0.0)
    return (
        f"{wheel.name} is older than the course; {BUILD}" if wheel.stat().st_mtime < changed else ""
    )


def carried(files: Mapping[str, bytes], wheel: Path | None, source: str) -> dict[str, bytes]:
    """Return a release's files with the wheel beside its notebooks, which know the address, too.

    Raises InputError: `source` is no address.
    """
    found = {
        path: with_address(data, source) if source and path.endswith(".ipynb") else data
        for path, data in files.items()
    }
    if wheel is not None and any(path.endswith(".ipynb") for path in found):
        found[f"{NOTEBOOKS}/{wheel.name}"] = wheel.read_bytes()
    return found
