"""The layers between a host and the machine: which there are here, and how a host puts them on.

Each is independent of the others. `limits` is always there; the rest depends on the kernel and on
who runs the grader. The judge may leave layers out, to show what each is for.
"""

from __future__ import annotations

import functools
import os
import sys
import sysconfig
from collections.abc import Collection
from pathlib import Path

from ..frames import Hello, Request
from . import kernel_filters, limits, users

LIMITS, USER, MOUNTS, NETWORK, FILES, CALLS = (
    "limits", "user", "mounts", "network", "files", "calls",
)  # fmt: skip
LAYERS = (LIMITS, USER, MOUNTS, NETWORK, FILES, CALLS)
HERE = Path(__file__).parent.parent  # rclpy_virtual_time/host
SYSTEM = (  # what the interpreter and its libraries read besides their own files
    "/usr", "/lib", "/lib64", "/bin",
    "/etc/ld.so.cache", "/etc/localtime", "/etc/os-release",
    "/proc/self", "/proc/cpuinfo", "/proc/meminfo", "/proc/stat", "/proc/sys/vm/overcommit_memory",
    "/sys/devices/system/cpu", "/sys/devices/system/node", "/sys/fs/cgroup",
    "/dev/null", "/dev/zero", "/dev/random", "/dev/urandom",
)  # fmt: skip
DEVICES = (Path("/dev/null"), Path("/dev/shm"))


def begin(wanted: Collection[str]) -> bool:
    """Get the right to mounts and networks of one's own; call it before any thread starts."""
    return users.is_root() or (not {MOUNTS, NETWORK}.isdisjoint(wanted) and users.own_user())


def prepare(wanted: Collection[str], *, may_mount: bool, newest: int) -> Hello:
    """Do in the fork server what its hosts need; return what they can have.

    `newest` is the newest Landlock that they may use.
    """
    found = [LIMITS]
    needed_paths()  # looked up once, not in each host
    if may_mount:
        mounts = users.own_mounts()
        if USER in wanted and users.is_root() and users.open_to_others(needed_paths()):
            found.append(USER)
        if MOUNTS in wanted and mounts:
            found.append(MOUNTS)
        if NETWORK in wanted and users.own_network():
            found.append(NETWORK)
    abi = min(kernel_filters.landlock_abi(), newest)
    if FILES in wanted and abi:
        found.append(FILES)
    if CALLS in wanted and kernel_filters.has_seccomp():
        found.append(CALLS)
    ordinary = not users.is_root() and may_mount
    counted = USER in found or (ordinary and users.can_count_own_processes())
    return Hello(tuple(found), abi if FILES in found else 0, counted)


def enter(request: Request, means: Hello, *, parent: int, datagrams: bool) -> None:
    """Put the layers on, in this process, for good; `parent` is the fork server."""
    folder = Path(request.folder)
    if MOUNTS in request.layers:
        users.private_mounts(folder, needed_paths())
        os.chdir(folder)
    limits.set_limits()
    limits.die_first()
    if USER in request.layers:
        users.drop_to(request.uid)
    elif not users.is_root():
        if means.counted:
            users.count_own_processes()
        users.drop_capabilities()
    kernel_filters.die_with_parent(parent)
    if FILES in request.layers:
        kernel_filters.restrict_files(readable_paths(), [folder, *DEVICES], means.landlock)
    if CALLS in request.layers:
        kernel_filters.restrict_calls(datagrams=datagrams, reserving=MOUNTS in request.layers)


@functools.cache
def needed_paths() -> list[Path]:
    """Return the folders of the interpreter, its libraries and this package."""
    checkout = HERE.parent.parent.resolve()
    installed = checkout == Path(sysconfig.get_path("purelib")).resolve()
    paths = [Path(sys.prefix), Path(sys.base_prefix), HERE]
    paths += [Path(entry) for entry in sys.path if entry]
    paths += [Path(entry) for entry in os.environ.get("LD_LIBRARY_PATH", "").split(":") if entry]
    found = [path.resolve() for path in paths if path.is_dir()]
    return [path for path in found if installed or path != checkout]


def readable_paths() -> list[Path]:
    """Return all that a host may read: no solutions, scenarios or other students' files."""
    own = [*needed_paths(), HERE.parent / "__init__.py"]
    own += [Path(os.environ[n]) for n in os.environ if n.endswith("_DEFAULT_PROFILES_FILE")]
    return [*own, *map(Path, SYSTEM)]
