"""Run nodes from elsewhere in plain Python and in a host; compare how they end and what they say.

A node is a file that imports rclpy and has a `main`, or that is a script. It is started as
`ros2 run` does it: its package is imported and `main()` called. A client that needs a server has it
beside it, as a program of its own (`nodes.toml`).
"""

from __future__ import annotations

import re
import shutil
import tempfile
import tomllib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path

import msgspec

from grader.authoring.conform import places
from grader.authoring.conform.places import Ran
from grader.host.frames import ProgramStart
from grader.link.hosts import ForkServer
from grader.link.output import ROS_LINE

SETTINGS = Path(__file__).with_name("nodes.toml")
SECONDS = 6  # that each node runs, in both places
NOT_NODES = {"setup.py", "__init__.py", "conftest.py"}
NOT_FOLDERS = {"launch", "test", "tests"}
START = """\
import sys
sys.path.insert(0, {root!r})
"""
CALL = "from {module} import main\nsys.exit(main())\n"
SCRIPT = "import runpy\nrunpy.run_path({file!r}, run_name='__main__')\n"


class Setting(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What some nodes need."""

    nodes: tuple[str, ...]  # patterns of files
    beside: tuple[str, ...] = ()  # patterns of the files that run beside them
    arguments: tuple[str, ...] = ()  # of their command lines


@dataclass(frozen=True)
class Node:
    """A node to run."""

    name: str  # "examples/rclpy/topics/…/publisher_member_function.py"
    file: Path

    @property
    def root(self) -> Path:
        """The folder from which its package is imported."""
        folder = self.file.parent
        while (folder / "__init__.py").exists():
            folder = folder.parent
        return folder

    def start_in(self, folder: Path) -> Path:
        """Write the program that starts it; return its file."""
        copy = folder / f"package_{self.root.name}"
        if not copy.exists():
            shutil.copytree(self.root, copy, ignore=shutil.ignore_patterns("test", "resource"))
        inner = self.file.relative_to(self.root)
        program = folder / f"start_{self.file.stem}.py"
        module = ".".join(inner.with_suffix("").parts)
        callable_ = re.search(r"(?m)^def main\(", self.file.read_text("utf-8"))
        start = CALL.format(module=module) if callable_ else SCRIPT.format(file=str(copy / inner))
        program.write_text(START.format(root=str(copy)) + start, "utf-8")
        return program


@dataclass(frozen=True)
class Behaviour:
    """What a node did."""

    outcome: str  # "runs", "ends", "lacks MODULE", or the exception
    said: frozenset[str]  # lines, their numbers left out


def find_nodes(folder: Path) -> Iterator[Node]:
    """Yield the nodes of all checkouts in a folder, in order of their names."""
    for file in sorted(folder.rglob("*.py")):
        name = file.relative_to(folder)
        if file.name in NOT_NODES or not NOT_FOLDERS.isdisjoint(name.parts):
            continue
        text = file.read_text("utf-8")
        runnable = re.search(r"(?m)^def main\(|^if __name__ ==", text)
        if re.search(r"(?m)^\s*(import|from) rclpy\b", text) and runnable:
            yield Node(name.as_posix(), file)


def run_node(node: Node, others: Sequence[Node], forkserver: ForkServer) -> dict[str, Behaviour]:
    """Run a node in both places, with those of the other nodes beside it that it needs."""
    setting = _setting(node)
    beside = [n for n in others if any(fnmatchcase(n.name, p) for p in setting.beside)]

    def programs(folder: Path) -> list[ProgramStart]:
        """Return the node's program, and, started first, those beside it."""
        starts = [ProgramStart(str(n.start_in(folder)), _setting(n).arguments) for n in beside]
        own = ProgramStart(str(node.start_in(folder)), setting.arguments)
        return [*starts, own]

    with tempfile.TemporaryDirectory(prefix="conform-") as name:
        folder = Path(name)
        commands = [[start.file, *start.arguments] for start in programs(folder)]
        plain = places.run_plain(forkserver, folder, commands, SECONDS)
    with tempfile.TemporaryDirectory(prefix="conform-") as name:
        folder = Path(name)
        inside = places.run_inside(forkserver, folder, programs(folder), SECONDS)
    return {"plain": _behaviour(plain), "inside": _behaviour(inside)}


def compared(both: dict[str, Behaviour]) -> tuple[str, str]:
    """Put into words how a node ended in each place; the same words if it did the same."""
    plain, inside = both["plain"], both["inside"]
    if plain.outcome != inside.outcome or plain.said == inside.said:
        return plain.outcome, inside.outcome
    return plain.outcome, f"{inside.outcome}, says other things"


def _setting(node: Node) -> Setting:
    known = msgspec.convert(tomllib.loads(SETTINGS.read_text("utf-8"))["node"], list[Setting])
    for setting in known:
        if any(fnmatchcase(node.name, pattern) for pattern in setting.nodes):
            return setting
    return Setting(())


def _behaviour(ran: Ran) -> Behaviour:
    text = f"{ran.text}\n{ran.said}"
    lines = [line for line in ran.said.splitlines() if line.strip()]
    said = {ROS_LINE.sub(r"\3", line) for line in lines}
    shapes = frozenset(re.sub(r"-?\d[\d.e+-]*", "#", line).strip() for line in said)
    lacks = re.search(r"No module named '([^'.]+)", text)
    error = re.findall(
        r"(?m)^(?:start_\w+\.py: )?((?:(?:\w+\.)*\w*(?:Error|Exception)|\w+\.error)\b.*)", text
    )
    if lacks:
        return Behaviour(f"lacks {lacks[1]}", frozenset())
    if ran.kind == "time":
        return Behaviour("runs", shapes)
    if ran.kind in ("returned", "exited") and not error:
        return Behaviour("ends", shapes)
    return Behaviour(error[-1].split(":")[0] if error else ran.kind, frozenset())
