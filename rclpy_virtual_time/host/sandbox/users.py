"""Who a host runs as, and what it sees: an unprivileged user, mounts and a network of its own.

`kernel_filters.py` has what Linux offers without root; `layers.py` decides which layers are put on.
"""

from __future__ import annotations

import contextlib
import ctypes
import fcntl
import os
import resource
import signal
import socket
import stat
import struct
from collections.abc import Iterator
from pathlib import Path

from .amounts import MAX_PROCESSES

# Users that exist only while something runs, by the convention of systemd's DynamicUser=. Each host
# is another one: it can't signal or trace its neighbours, and its limit on processes is its own.
USERS = range(61184, 65520)
PRIORITY = -20  # nice value
SLICE = 100_000  # [ns] of CPU at a time: who asks for short slices runs sooner (Linux 6.12)
SCHED_SETATTR = 314  # the system call's number on x86-64
CLONE_NEWNS, CLONE_NEWUSER, CLONE_NEWNET = 0x00020000, 0x10000000, 0x40000000
PR_CAPBSET_DROP, MAX_CAPABILITIES = 24, 64
CAPABILITY_VERSION = 0x20080522  # _LINUX_CAPABILITY_VERSION_3: two words of each set
SIOCGIFFLAGS, SIOCSIFFLAGS, IFF_UP = 0x8913, 0x8914, 1
SHM_SIZE = "64m"
ROUNDS = 100
MS_BIND, MS_REC, MS_PRIVATE = 4096, 16384, 1 << 18
MNT_DETACH = 2


def is_root() -> bool:
    """Return whether this process may become any of `USERS`, or the one behind them.

    Not so root in a user namespace without them: `unshare --map-root-user`, Apptainer's fakeroot.
    """
    if os.geteuid() != 0:
        return False
    spans = (map(int, line.split()) for line in Path("/proc/self/uid_map").read_text().splitlines())
    return any(first <= USERS.start and USERS.stop < first + count for first, _, count in spans)


def take_priority() -> None:
    """Go before others on the machine, if that is allowed: real time leaves no time to wait.

    Where Linux groups processes by session (autogroup), the nice value counts only inside the
    group; the group's own is what others feel: see `prefer`.
    """
    with contextlib.suppress(OSError):
        os.setpriority(os.PRIO_PROCESS, 0, PRIORITY)
    nice = os.getpriority(os.PRIO_PROCESS, 0)
    attributes = struct.pack("IIQiIQQQ", 48, os.SCHED_OTHER, 0, nice, 0, SLICE, 0, 0)
    ctypes.CDLL(None).syscall(SCHED_SETATTR, 0, attributes, 0)  # older kernels change nothing


def prefer(pid: int) -> None:
    """Let the session of a process go before others on the machine, if that is allowed.

    Only a process with deadlines needs it: start-up uses much CPU, but is seldom urgent.
    """
    with contextlib.suppress(OSError):
        Path(f"/proc/{pid}/autogroup").write_text(str(PRIORITY))


@contextlib.contextmanager
def priority() -> Iterator[None]:
    """Let the calling thread go before all others until the block ends, if that is allowed.

    For trusted code that mostly waits. Its processes and threads don't inherit the priority.
    """
    before = os.sched_getscheduler(0), os.sched_getparam(0)
    with contextlib.suppress(OSError):
        first = os.sched_param(os.sched_get_priority_min(os.SCHED_RR))
        os.sched_setscheduler(0, os.SCHED_RR | os.SCHED_RESET_ON_FORK, first)
    try:
        yield
    finally:
        with contextlib.suppress(OSError):
            os.sched_setscheduler(0, *before)


def drop_to(uid: int) -> None:
    """Become an unprivileged user for good (needs root)."""
    resource.setrlimit(resource.RLIMIT_NPROC, (MAX_PROCESSES, MAX_PROCESSES))
    os.setgroups([])
    os.setresgid(uid, uid, uid)
    os.setresuid(uid, uid, uid)


def count_own_processes() -> None:
    """Let this process and its children count as a user's own (ordinary user, Linux 5.14).

    Linux counts processes and threads by user and user namespace. In one of its own a host has its
    own limit, and takes nothing from the user's.
    """
    _unshare_user()
    resource.setrlimit(resource.RLIMIT_NPROC, (MAX_PROCESSES, MAX_PROCESSES))


def can_count_own_processes() -> bool:
    """Return whether that works here: in a child, two processes fit where two are allowed."""
    child = os.fork()
    if child == 0:
        with contextlib.suppress(OSError):
            _unshare_user()
            resource.setrlimit(resource.RLIMIT_NPROC, (2, 2))
            first = os.fork()  # fails where the user's other processes count
            if first == 0:
                signal.pause()
            refused = _fork_is_refused()
            os.kill(first, signal.SIGKILL)
            os.waitpid(first, 0)
            os._exit(0 if refused else 1)
        os._exit(1)
    return os.waitpid(child, 0)[1] == 0


def _fork_is_refused() -> bool:
    try:
        second = os.fork()
    except OSError:
        return True
    if second == 0:
        os._exit(0)
    os.waitpid(second, 0)
    return False


def drop_capabilities() -> None:
    """Drop all capabilities for good."""
    header, nothing = struct.pack("Ii", CAPABILITY_VERSION, 0), bytes(24)
    libc = ctypes.CDLL(None, use_errno=True)
    if libc.capset(header, nothing):
        raise OSError(ctypes.get_errno(), "capset")


def never_gain_capabilities() -> None:
    """Let no program that this process becomes have a capability, not even as root."""
    libc = ctypes.CDLL(None, use_errno=True)
    for capability in range(MAX_CAPABILITIES):
        libc.prctl(PR_CAPBSET_DROP, capability, 0, 0, 0)  # unknown or not permitted: ignored


def own_user() -> bool:
    """Give this process, of an ordinary user, root's rights over namespaces of its own.

    Some machines forbid that (Docker), others allow the step and not what comes after (AppArmor on
    Ubuntu 24.04), so a child tries first. Return whether it worked. There must be no other thread.
    """
    child = os.fork()
    if child == 0:
        with contextlib.suppress(OSError):
            _unshare_user()
            _unshare_mounts()
            mount("tmpfs", "/dev/shm", "tmpfs", 0, "size=4k")
            os._exit(0)
        os._exit(1)
    if os.waitpid(child, 0)[1]:
        return False
    _unshare_user()
    return True


def own_mounts() -> bool:
    """Give this process a mount namespace of its own; tell whether that worked."""
    try:
        _unshare_mounts()
    except OSError:
        return False
    return True


def own_network() -> bool:
    """Give this process a network of its own, with nothing but loopback."""
    libc = ctypes.CDLL(None, use_errno=True)
    if libc.unshare(CLONE_NEWNET):
        return False
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as any_socket:
        request = struct.pack("16sh14x", b"lo", 0)
        flags = struct.unpack("16sh14x", fcntl.ioctl(any_socket, SIOCGIFFLAGS, request))[1]
        fcntl.ioctl(any_socket, SIOCSIFFLAGS, struct.pack("16sh14x", b"lo", flags | IFF_UP))
    return True


def private_mounts(folder: Path, needed: list[Path]) -> None:
    """Give this process a /dev/shm and a temporary folder of its own (needs own mounts).

    Of the folder that holds `folder` nothing stays visible but that, and what is `needed` in there.
    """
    _unshare_mounts()
    mount("tmpfs", "/dev/shm", "tmpfs", 0, f"mode=1777,size={SHM_SIZE}")
    inside = [path for path in needed if path.is_relative_to(folder.parent)]
    _expose_only(folder.parent, [folder, *inside])


def end_all_of(uid: int) -> None:
    """End every process of a user, also those that hid in a session of their own (needs root)."""
    for _ in range(ROUNDS):  # one that forks can escape a round, not all: its processes are limited
        names = filter(str.isdigit, os.listdir("/proc"))  # noqa: PTH208  (all of a machine's)
        found = [int(name) for name in names if _is_of(name, uid)]
        for pid in found:
            with contextlib.suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)
        if not found:
            return


def _is_of(pid: str, uid: int) -> bool:
    """Return whether a process lives and is a user's."""
    try:
        if os.stat(f"/proc/{pid}").st_uid != uid:  # noqa: PTH116
            return False
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def open_to_others(paths: list[Path]) -> bool:
    """Make sure that an unprivileged user can reach `paths`; tell whether that worked.

    An interpreter in root's home is closed to everybody else. Then, in this process's own mounts,
    the closed folder is replaced by an empty one that holds nothing but `paths`.
    """
    closed: dict[Path, list[Path]] = {}
    for path in paths:
        folder = closed_ancestor(path)
        if folder is not None:
            closed.setdefault(folder, []).append(path)
    if not closed:
        return True
    try:
        for folder, inside in closed.items():
            _expose_only(folder, inside)
    except OSError:
        return False
    return all(closed_ancestor(path) is None for path in paths)


def closed_ancestor(path: Path) -> Path | None:
    """Return the outermost folder on the way to `path` that is closed to other users."""
    for folder in reversed([path, *path.parents]):
        if folder.is_dir() and not folder.stat().st_mode & stat.S_IXOTH:
            return folder
    return None


def _unshare_user() -> None:
    uid, gid = os.getuid(), os.getgid()
    libc = ctypes.CDLL(None, use_errno=True)
    if libc.unshare(CLONE_NEWUSER):
        raise OSError(ctypes.get_errno(), "unshare")
    Path("/proc/self/setgroups").write_text("deny")
    Path("/proc/self/uid_map").write_text(f"{uid} {uid} 1")
    Path("/proc/self/gid_map").write_text(f"{gid} {gid} 1")


def _unshare_mounts() -> None:
    libc = ctypes.CDLL(None, use_errno=True)
    if libc.unshare(CLONE_NEWNS):
        raise OSError(ctypes.get_errno(), "unshare")
    mount("none", "/", None, MS_REC | MS_PRIVATE)


def _expose_only(folder: Path, inside: list[Path]) -> None:
    handles = [(path, os.open(path, os.O_PATH)) for path in _outermost(inside)]
    mount("tmpfs", str(folder), "tmpfs", 0, "mode=0755,size=1m")
    for path, handle in handles:
        path.mkdir(parents=True, exist_ok=True)
        mount(f"/proc/self/fd/{handle}", str(path), None, MS_BIND | MS_REC)
        os.close(handle)


def _outermost(paths: list[Path]) -> list[Path]:
    chosen: list[Path] = []
    for path in sorted(set(paths)):
        if not any(path.is_relative_to(other) for other in chosen):
            chosen.append(path)
    return chosen


def mount(source: str, target: str, kind: str | None, flags: int, options: str = "") -> None:
    """Call mount(2), in the mounts of this process."""
    libc = ctypes.CDLL(None, use_errno=True)
    arguments = (
        source.encode(),
        target.encode(),
        kind.encode() if kind else None,
        ctypes.c_ulong(flags),
        options.encode() or None,
    )
    if libc.mount(*arguments):
        error = ctypes.get_errno()
        raise OSError(error, os.strerror(error), target)


def unmount(target: Path) -> None:
    """Take away a mount; a process that still works in it keeps it until its end."""
    libc = ctypes.CDLL(None, use_errno=True)
    if libc.umount2(str(target).encode(), MNT_DETACH):
        error = ctypes.get_errno()
        raise OSError(error, os.strerror(error), str(target))
