"""Packages of interfaces of a student's own: what colcon builds of them, and where that lies.

Only text is handed over: a node's process makes the classes of it.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from fnmatch import fnmatchcase
from pathlib import Path

from rclpy_virtual_time import open_regular_file

KINDS = ("msg", "srv", "action")
BUILD, MANIFEST = "CMakeLists.txt", "package.xml"
NAMED = re.compile(r"<name>\s*([a-z][a-z0-9_]*)\s*</name>")
LISTED = re.compile(r"\b(?:msg|srv|action)/[\w*]+\.(?:msg|srv|action)\b")


def installed(files: Mapping[str, Path]) -> dict[str, Path]:
    """Return the definitions among a package's files that its CMakeLists.txt names, by place."""
    if not {BUILD, MANIFEST} <= files.keys():
        return {}
    build, name = re.sub("#.*", "", _text(files[BUILD])), NAMED.search(_text(files[MANIFEST]))
    if "rosidl_generate_interfaces" not in build or name is None:
        return {}
    listed = LISTED.findall(build)
    named = (each for each in files if any(fnmatchcase(each, pattern) for pattern in listed))
    return {f"share/{name[1]}/{each}": files[each] for each in named}


def _text(file: Path) -> str:
    with open_regular_file(file) as opened:
        return opened.read(100_000).decode("utf-8", "replace")
