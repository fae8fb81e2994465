"""What this machine offers to the grader, and what stays open on it."""

from __future__ import annotations

import contextlib
import importlib.metadata
import platform
from collections.abc import Collection, Mapping
from dataclasses import dataclass

from grader.errors import GraderError, InputError
from grader.host.sandbox.layers import CALLS, FILES, LAYERS, LIMITS, MOUNTS, NETWORK, USER
from grader.host.sandbox.limits import MAX_DESCRIPTORS, MAX_FILE, MAX_MEMORY
from grader.link.hosts import ForkServer
from sim.messages import EPOCH_NS

EXTRAS: Mapping[str, tuple[str, ...]] = {  # what it is for: distributions
    "exercise 2, 5, 6, 8 and 9 (extra `ml`)": ("scikit-learn", "onnxruntime", "onnx", "skl2onnx"),
    "PyTorch and Keras in exercise 8 (extra `deep`)": ("torch", "keras"),
    "grading on a cluster (extra `cluster`)": ("distributed",),
    "notebooks (extra `notebooks`)": ("jupyterlab", "nbgrader"),
}
NEEDS: Mapping[str, str] = {  # a layer: what a machine must have for it
    LIMITS: "any Linux",
    USER: "the grader run as root",
    MOUNTS: "the grader run as root, or user namespaces that anybody may make",
    NETWORK: "as for mounts",
    FILES: "Landlock: Linux 5.13 or later, built and started with it",
    CALLS: "seccomp filters, on x86_64 or arm64",
}
KEEPS: Mapping[str, str] = {
    LIMITS: f"core dumps, files over {MAX_FILE >> 20} MiB, more than {MAX_DESCRIPTORS} "
    f"descriptors, more than {MAX_MEMORY >> 30} GiB of memory",
    USER: "signals to the grader and to other students' nodes, files that are not for everybody",
    MOUNTS: "/tmp, and shared memory of other programs",
    NETWORK: "the network, this machine's own services too",
    FILES: "every file but the interpreter, its libraries and the node's own folder",
    CALLS: "programs, processes, sockets, tracing, other processes' memory, kernel features",
}
OPENS: Mapping[str, str] = {  # what is possible without a layer, whatever the others do
    LIMITS: "a node can fill memory and disk",
    USER: "all nodes are the same user as the grader, and share its limits on processes",
    MOUNTS: "nodes see each other's shared memory, and can fill /dev/shm",
    NETWORK: "nothing while seccomp is there; else connections to anywhere",
    FILES: "a node reads what its user can read: solutions, scenarios, other submissions",
    CALLS: "a node can start programs, and open connections unless it has no network",
}


@dataclass(frozen=True)
class Layer:
    """One layer of isolation on this machine."""

    name: str
    here: bool

    @property
    def text(self) -> str:
        """What it keeps out, or what stays open without it."""
        return f"keeps out: {KEEPS[self.name]}" if self.here else f"open: {OPENS[self.name]}"


@dataclass(frozen=True)
class Diagnosis:
    """What was found."""

    python: str
    ros: str  # "" if there is none
    problem: str  # why no node can run here; "" if one can
    layers: tuple[Layer, ...]
    extras: Mapping[str, tuple[str, ...]]  # what it is for: distributions that are missing

    @property
    def foreign_code(self) -> str:
        """Why other people's code should not be graded here; "" if it may."""
        return foreign_code_problem({layer.name for layer in self.layers if layer.here})


def foreign_code_problem(layers: Collection[str]) -> str:
    """Say why other people's code should not run behind these layers; "" if it may."""
    if FILES in layers:
        return ""
    return (
        "nothing keeps a submission from reading solutions, secrets and other submissions "
        f"(needed: {NEEDS[FILES]}); use a throw-away machine, and say so with --trust"
    )


def diagnose() -> Diagnosis:
    """Look at this machine, and start a host to see what it has."""
    ros, problem = "", ""
    found: tuple[str, ...] = ()
    try:
        with ForkServer(EPOCH_NS) as forkserver:
            found = forkserver.layers
            ros = forkserver.ros.kind
    except (GraderError, InputError) as error:
        problem = str(error)
    return Diagnosis(
        python=f"{platform.python_version()} on {platform.platform(terse=True)}",
        ros=ros,
        problem=problem,
        layers=tuple(Layer(name, name in found) for name in LAYERS),
        extras={what: tuple(filter(_is_missing, names)) for what, names in EXTRAS.items()},
    )


def _is_missing(distribution: str) -> bool:
    with contextlib.suppress(importlib.metadata.PackageNotFoundError):
        importlib.metadata.version(distribution)
        return False
    return True
