"""What this machine offers to the grader, and what stays open on it."""

from __future__ import annotations

import os
import platform
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass

from rclpy_virtual_time.host.frames import Hello
from rclpy_virtual_time.host.sandbox import users
from rclpy_virtual_time.host.sandbox.amounts import (
    MAX_FILE,
    MAX_FOLDER,
    MAX_MEMORY,
    MAX_OPEN_FILES,
    MAX_PROCESSES,
)
from rclpy_virtual_time.host.sandbox.layers import (
    CALLS,
    FILES,
    LAYERS,
    LIMITS,
    MOUNTS,
    NETWORK,
    USER,
)
from rclpy_virtual_time.link.errors import EngineError
from rclpy_virtual_time.link.hosts import ForkServer
from rclpy_virtual_time.link.launcher import FOREIGN_CODE, NEEDS_FILES
from rclpy_virtual_time.link.pipes import PATROL
from rclpy_virtual_time.link.settings import EPOCH
from rclpy_virtual_time.link.trouble import trouble

TRUNCATE_SINCE = 3  # version of Landlock that minds how files are emptied
NEEDS: Mapping[str, str] = {  # a layer: what a machine must have for it
    LIMITS: "any Linux",
    USER: "the grader run as root",
    MOUNTS: "the grader run as root, or user namespaces that anybody may make",
    NETWORK: "the same as mounts",
    FILES: NEEDS_FILES,
    CALLS: "seccomp filters, on x86_64 or arm64",
}
KEEPS: Mapping[str, str] = {
    LIMITS: f"core dumps, files over {MAX_FILE >> 20} MiB, more than {MAX_OPEN_FILES} "
    f"descriptors, more than {MAX_MEMORY >> 30} GiB of memory",
    USER: "signals to the grader and to other students' nodes, files that are not for everybody",
    MOUNTS: f"/tmp, shared memory of other programs, more than {MAX_FOLDER >> 20} MiB of files",
    NETWORK: "the network, this machine's own services too",
    FILES: "every file but the interpreter, its libraries and the node's own folder",
    CALLS: "programs, processes, sockets, tracing, other processes' memory, kernel features",
}


@dataclass(frozen=True)
class Layer:
    """One layer of isolation on this machine."""

    name: str
    here: bool
    version: str = ""  # of what the kernel offers for it

    @property
    def text(self) -> str:
        """What it keeps out, or what it needs; `gaps` says what is open without it."""
        if not self.here:
            return f"needs {NEEDS[self.name]}"
        return f"keeps out: {KEEPS[self.name]}{f' ({self.version})' if self.version else ''}"


@dataclass(frozen=True)
class Diagnosis:
    """What was found."""

    python: str
    ros: str  # "" if there is none
    problem: str  # why no node can run here; "" if one can
    layers: tuple[Layer, ...]
    gaps: tuple[str, ...] = ()  # what a submission can still do to a class, a sentence each
    trouble: tuple[str, ...] = ()  # what a class would fail on, a sentence each

    @property
    def foreign_code(self) -> str:
        """Why other people's code should not be graded here; "" if it may."""
        return "" if any(each.here and each.name == FILES for each in self.layers) else FOREIGN_CODE

    @staticmethod
    def of_this_machine() -> Diagnosis:
        """Look at this machine, and start a host to see what it has."""
        ros, problem = "", ""
        means = Hello(())
        try:
            with ForkServer(EPOCH) as forkserver:
                means = forkserver.means
                ros = f"{forkserver.ros.distro.capitalize()}, {forkserver.ros.kind}"
                if (sourced := os.environ.get("ROS_DISTRO", "")) not in ("", forkserver.ros.distro):
                    ros += f"; {sourced.capitalize()} is sourced, and not used here"
        except EngineError as error:
            problem = str(error)
        return Diagnosis(
            python=f"{platform.python_version()} on {platform.platform(terse=True)}",
            ros=ros,
            problem=problem,
            layers=tuple(
                Layer(name, name in means.layers, _version(name, means)) for name in LAYERS
            ),
            gaps=() if problem else gaps(means, root=users.is_root()),
            trouble=trouble(means.layers),
        )


def gaps(means: Hello, *, root: bool) -> tuple[str, ...]:
    """Say in plain words what these means of isolation leave open; nothing if nothing."""
    there = set(means.layers)
    shared = MOUNTS not in there
    found = {
        "Submissions run as root: without the sandbox's other layers they can do everything "
        "(let an ordinary user grade).": root and USER not in there,
        "A submission can read solutions, secrets and other submissions.": FILES not in there,
        f"Landlock {means.landlock} lets files be emptied that can't be written, and no filter of "
        "system calls refuses it: the grader's own files and results can be lost.": (
            FILES in there and means.landlock < TRUNCATE_SINCE and CALLS not in there
        ),
        "A submission can start programs and processes, and they may outlive the grader.": (
            CALLS not in there
        ),
        "A submission can talk to the network.": CALLS not in there and NETWORK not in there,
        "In real time a submission can send datagrams anywhere.": NETWORK not in there,
        f"The folders of submissions lie on the disk of {tempfile.gettempdir()}: the grader looks "
        f"every {PATROL * 1e3:.0f} ms and ends what goes past {MAX_FOLDER >> 20} MiB, but a disk "
        "that is nearly full can be filled.": shared,
        "A submission can fill /dev/shm, and then no other node starts.": shared,
        f"The kernel does not count a submission's threads: the grader ends more than "
        f"{MAX_PROCESSES}, but for a moment they can take all that the user may have.": (
            not means.counted
        ),
    }
    return tuple(text for text, is_open in found.items() if is_open)


def _version(layer: str, means: Hello) -> str:
    return f"Landlock ABI {means.landlock}" if layer == FILES and means.landlock else ""
