"""Packages of interfaces of a student's own: what colcon builds of them, and where that lies.

Only text is handed over: a node's process makes the classes of it.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from fnmatch import fnmatchcase
from pathlib import Path

from rclpy_virtual_time import open_regular_file

KINDS = ("msg", "srv", "action")
BUILD, MANIFEST = "CMakeLists.txt", "package.xml"
NAMED = re.compile(r"<name>\s*([a-z][a-z0-9_]*)\s*</name>")
DEFINITION = re.compile(r"(msg|srv|action)/[^/]+\.\1")
LISTED = re.compile(r"\b(?:msg|srv|action)/[\w*]+\.(?:msg|srv|action)\b")
GENERATE = "rosidl_generate_interfaces"
GROUP = "<member_of_group>rosidl_interface_packages</member_of_group>"
STOPS = "On a robot colcon build"
USED = re.compile(r"^([a-z]\w*)/[A-Z]", re.MULTILINE)
BRING = {  # what packages of messages need themselves, and so bring along
    "builtin_interfaces": r"_msgs|srv/|action/", "std_msgs": r"(?<!\bstd)_msgs",
    "geometry_msgs": r"\b(nav|sensor|shape|trajectory|visualization|tf2)_msgs",
}  # fmt: skip


def taken(files: Mapping[str, Path], tops: Iterable[str]) -> tuple[dict[str, Path], list[str]]:
    """Return files, and of definitions below `tops` what colcon installs; and what stops it."""
    found, said = dict(files), list[str]()
    for top in tops:
        inside = {n.removeprefix(top): file for n, file in files.items() if n.startswith(top)}
        defined = [n for n in inside if DEFINITION.fullmatch(n)]
        if not defined or not {BUILD, MANIFEST} <= inside.keys():
            continue
        for each in defined if top else ():
            del found[top + each]
        build, name = re.sub("#.*", "", _text(inside[BUILD])), NAMED.search(_text(inside[MANIFEST]))
        listed = LISTED.findall(build) if name and GENERATE in build else ()
        for each in defined:
            if name and any(fnmatchcase(each, pattern) for pattern in listed):
                found[f"share/{name[1]}/{each}"] = inside[each]
        if why := next(_unbuilt(inside, build, name), ""):
            does = "stops" if GENERATE in build else "makes no interfaces"
            said.append(f"{STOPS} {does}: {top}{why}")
    return found, said


def _unbuilt(files: Mapping[str, Path], build: str, name: re.Match[str] | None) -> Iterator[str]:
    """Yield what is known to stop colcon in a package of interfaces of this name."""
    if name is None:
        yield f"{MANIFEST}: expected a <name> of small letters, digits and _"
    if GENERATE not in build:
        yield f"{BUILD} has no {GENERATE}(…)"
    listed = LISTED.findall(build)
    if gone := [each for each in listed if "*" not in each and each not in files]:
        yield f"{BUILD} names {gone[0]}, but there is no such file"
    if "ament_auto" in build:  # it finds what package.xml names
        return
    if GROUP not in re.sub(r"\s", "", _text(files[MANIFEST])):
        yield f"{MANIFEST} lacks {GROUP}"
    used = {name for each in listed if each in files for name in USED.findall(_text(files[each]))}
    for each in ("rosidl_default_generators", *sorted(used - {name[1] if name else ""})):
        named = len(re.findall(rf"\b{each}\b", build))
        alone = each in used and named == 1 and re.search(rf"find_package\(\s*{each}\b", build)
        if (alone or not named) and not re.search(BRING.get(each, "$."), build):
            also = f" and DEPENDENCIES {each}" * (each in used)
            yield f"{BUILD} wants find_package({each} REQUIRED){also}"


def _text(file: Path) -> str:
    with open_regular_file(file) as opened:
        return opened.read(100_000).decode("utf-8", "replace")
