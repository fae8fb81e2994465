"""The filter of system calls, in processes of its own: what is refused, and what still works."""

import ctypes
import errno
import faulthandler
import fcntl
import mmap
import os
import platform
import resource
import signal
import socket
import threading
from collections.abc import Callable
from pathlib import Path

import pytest
from children import error_of, in_child

from rclpy_virtual_time.host.sandbox import kernel_filters as sandbox
from rclpy_virtual_time.host.sandbox.kernel_filters import CALLS, MAP_GROWSDOWN, PRETENDED, X32_BIT

X86 = platform.machine() == "x86_64"
COLUMN = 0 if X86 else 1
libc = ctypes.CDLL(None, use_errno=True)

filters = pytest.mark.skipif(not sandbox.has_seccomp(), reason="this kernel has no seccomp filters")
x86_only = pytest.mark.skipif(not X86, reason="only x86_64 has these calls")


def call(number: int, *arguments: object) -> int:
    """Call the kernel; return the error's number, 0 if there was none."""
    ctypes.set_errno(0)
    done = libc.syscall(ctypes.c_long(number), *arguments)
    return ctypes.get_errno() if done < 0 else 0


def filtered(body: Callable[[], object], *, datagrams: bool = False) -> str:
    """Run a function in a child behind the filter of calls."""

    def run() -> object:
        sandbox.restrict_calls(datagrams=datagrams)
        return body()

    return in_child(run)


# --- system calls --------------------------------------------------------------------------------


def numbers(table: dict[str, tuple[int, int]]) -> dict[str, int]:
    return {name: both[COLUMN] for name, both in table.items() if both[COLUMN] != sandbox.NONE}


@filters
def test_each_refused_call_is_refused() -> None:
    """With arguments that make no sense: what comes is the filter's error, not the call's own."""
    refused = numbers(CALLS)
    said = filtered(lambda: {name: call(number, *[-1] * 6) for name, number in refused.items()})

    assert said == repr(dict.fromkeys(refused, errno.EPERM))


@filters
def test_each_pretended_call_does_nothing(tmp_path: Path) -> None:
    pretended = numbers(PRETENDED)
    said = filtered(lambda: {name: call(number, *[-1] * 6) for name, number in pretended.items()})
    assert said == repr(dict.fromkeys(pretended, 0))

    file = tmp_path / "file"
    file.write_text("x")
    before = file.stat()
    assert filtered(lambda: (os.chmod(file, 0o777), os.utime(file, (1, 1)))) == "(None, None)"
    assert (file.stat().st_mode, file.stat().st_mtime) == (before.st_mode, before.st_mtime)


@filters
@x86_only
def test_the_other_numbers_of_the_same_calls_are_refused() -> None:
    """x32: nearly all calls of x86_64 once more, at other numbers."""
    names = {"open": 2, "socket": 41, "getpid": 39, "ptrace": 521, "execve": 520, "nonsense": 9_999}
    said = filtered(lambda: {name: call(X32_BIT + number) for name, number in names.items()})
    assert said == repr(dict.fromkeys(names, errno.ENOSYS))


@filters
@x86_only
def test_calls_of_32_bits_end_the_process() -> None:
    """`int 0x80` has a table of its own."""
    code = bytes.fromhex("b814000000cd80c3")  # mov eax, 20 (getpid); int 0x80; ret

    def run() -> int:
        rights = mmap.PROT_READ | mmap.PROT_WRITE | mmap.PROT_EXEC
        page = mmap.mmap(-1, 4096, flags=mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS, prot=rights)
        page.write(code)
        address = ctypes.addressof(ctypes.c_char.from_buffer(page))
        return int(ctypes.CFUNCTYPE(ctypes.c_int)(address)())

    assert filtered(run) in (f"exit status {-signal.SIGSYS}", f"exit status {-signal.SIGSEGV}")


PARENT = os.getpid()


def own_pipe(command: int) -> int:
    return fcntl.fcntl(os.pipe()[0], command, os.getpid())


def own_memory(flags: int) -> mmap.mmap:
    return mmap.mmap(-1, mmap.PAGESIZE, flags=flags | mmap.MAP_ANONYMOUS)


WAYS: dict[str, tuple[Callable[[], object], str]] = {
    "fork": (os.fork, "EPERM"),
    "exec": (lambda: os.execv("/bin/true", ["true"]), "EPERM"),
    "spawn": (lambda: os.posix_spawn("/bin/true", ["true"], {}), "EPERM"),
    "a signal to the parent": (lambda: os.kill(PARENT, 0), "EPERM"),
    "a signal to the first process": (lambda: os.kill(1, 0), "EPERM"),
    "a signal to its group": (lambda: os.kill(0, 0), "EPERM"),
    "a signal to all": (lambda: os.kill(-1, 0), "EPERM"),
    "a signal to the parent's group": (lambda: os.kill(-PARENT, 0), "EPERM"),
    "a pipe whose signals go elsewhere": (lambda: own_pipe(fcntl.F_SETOWN), "EPERM"),
    "a pipe that sends signals": (lambda: own_pipe(fcntl.F_SETSIG), "EPERM"),
    "a folder that sends signals": (lambda: own_pipe(fcntl.F_NOTIFY), "EPERM"),
    "a pipe that does not block": (lambda: own_pipe(fcntl.F_SETFL), "fine"),
    "memory of its own": (lambda: own_memory(mmap.MAP_PRIVATE), "fine"),
    "memory that no limit counts": (lambda: own_memory(mmap.MAP_SHARED), "ENOMEM"),
    "memory that grows like a stack": (
        lambda: own_memory(mmap.MAP_PRIVATE | MAP_GROWSDOWN), "ENOMEM",
    ),
    "a limit of its own": (lambda: resource.setrlimit(resource.RLIMIT_CORE, (0, 0)), "fine"),
    "a limit of the parent's": (
        lambda: resource.prlimit(PARENT, resource.RLIMIT_CORE, (0, 0)), "EPERM",
    ),
}  # fmt: skip


@filters
@pytest.mark.parametrize("way", WAYS)
def test_what_reaches_beyond_the_process_is_refused(way: str) -> None:
    body, wanted = WAYS[way]
    assert filtered(lambda: error_of(body)) == repr(wanted)


@filters
def test_clone_makes_threads_only() -> None:
    clone, clone3 = sandbox.CLONE[COLUMN], sandbox.CLONE3[COLUMN]
    assert filtered(lambda: call(clone, signal.SIGCHLD, 0, 0, 0, 0)) == str(errno.EPERM)
    assert filtered(lambda: call(clone3, 0, 0)) == str(errno.ENOSYS)

    def start() -> int:
        found: list[int] = []
        threads = [threading.Thread(target=found.append, args=(i,)) for i in range(5)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        return len(found)

    assert filtered(start) == "5"


@filters
def test_signals_to_the_process_itself_arrive() -> None:
    def itself() -> list[int]:
        got: list[int] = []
        signal.signal(signal.SIGUSR1, lambda number, _: got.append(number))
        os.kill(os.getpid(), signal.SIGUSR1)
        signal.raise_signal(signal.SIGUSR1)
        return [int(number) for number in got]

    assert filtered(itself) == repr([int(signal.SIGUSR1)] * 2)

    def abort() -> None:
        faulthandler.disable()
        os.abort()

    assert filtered(abort) == f"exit status {-signal.SIGABRT}"


@filters
def test_no_file_is_emptied_by_its_path(tmp_path: Path) -> None:
    file = tmp_path / "file"
    file.write_text("kept")
    assert filtered(lambda: error_of(lambda: os.truncate(file, 0))) == "'EPERM'"
    assert file.read_text() == "kept"

    def through_a_descriptor() -> None:
        with file.open("r+") as opened:
            opened.truncate(2)

    assert filtered(lambda: error_of(through_a_descriptor)) == "'fine'"
    assert file.read_text() == "ke"


@filters
def test_the_end_of_the_judge_stays_a_signal() -> None:
    prctl, name = sandbox.PRCTL[COLUMN], 15  # PR_SET_NAME, which threads use
    said = filtered(lambda: [call(prctl, sandbox.PR_SET_PDEATHSIG, 0), call(prctl, name, b"node")])
    assert said == f"[{errno.EPERM}, 0]"


SOCKETS = {
    "TCP": (socket.AF_INET, socket.SOCK_STREAM, 0),
    "UDP": (socket.AF_INET, socket.SOCK_DGRAM, 0),
    "UDP, closed on exec": (socket.AF_INET, socket.SOCK_DGRAM | socket.SOCK_CLOEXEC, 0),
    "UDP of IPv6": (socket.AF_INET6, socket.SOCK_DGRAM, 0),
    "raw": (socket.AF_INET, socket.SOCK_RAW, 1),
    "Unix": (socket.AF_UNIX, socket.SOCK_STREAM, 0),
    "packet": (socket.AF_PACKET, socket.SOCK_RAW, 0),
    "netlink for routes": (socket.AF_NETLINK, socket.SOCK_RAW, 0),
    "netlink between users": (socket.AF_NETLINK, socket.SOCK_RAW, 2),
    "netlink of the kernel": (socket.AF_NETLINK, socket.SOCK_RAW, 15),
}


@filters
@pytest.mark.parametrize("datagrams", [False, True])
@pytest.mark.parametrize("kind", SOCKETS)
def test_sockets(kind: str, datagrams: bool) -> None:
    allowed = kind == "netlink for routes" or (datagrams and kind.startswith("UDP,"))
    allowed |= datagrams and kind == "UDP"
    said = filtered(lambda: error_of(lambda: socket.socket(*SOCKETS[kind])), datagrams=datagrams)

    assert said == repr("fine" if allowed else "EPERM")


@filters
def test_what_nodes_need_works(tmp_path: Path) -> None:
    def work() -> int:
        (tmp_path / "file").write_text("text")
        os.rename(tmp_path / "file", tmp_path / "other")
        os.listdir("/proc/self/fd")
        os.mkdir(tmp_path / "folder")
        socket.socketpair()
        with (tmp_path / "other").open() as file:
            return len(file.read())

    assert filtered(work) == "4"


@filters
def test_the_filter_can_not_be_taken_off() -> None:
    def loosen() -> str:
        libc.prctl(sandbox.PR_SET_SECCOMP, 0, 0, 0, 0)
        libc.prctl(sandbox.PR_SET_NO_NEW_PRIVS, 0, 0, 0, 0)
        return error_of(os.fork)

    assert filtered(loosen) == "'EPERM'"


def test_another_architecture_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(platform, "machine", lambda: "riscv64")

    assert not sandbox.has_seccomp()
    with pytest.raises(OSError, match="riscv64"):
        sandbox.restrict_calls()


def test_the_numbers_differ_within_an_architecture() -> None:
    everything = {**CALLS, **PRETENDED}
    for column in (0, 1):
        found = [both[column] for both in everything.values() if both[column] != sandbox.NONE]
        assert len(found) == len(set(found))
    assert not CALLS.keys() & PRETENDED.keys()


@pytest.mark.parametrize("machine", sandbox.ARCHITECTURES)
@pytest.mark.parametrize("datagrams", [False, True])
def test_every_jump_lands_in_the_program(
    machine: str, datagrams: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(platform, "machine", lambda: machine)
    program = sandbox._filter(datagrams, reserving=False)

    assert len(program) < 4_096
    assert program[-1] == (sandbox.RETURN, 0, 0, sandbox.ALLOW)
    for index, (code, if_true, if_false, _) in enumerate(program):
        if code != sandbox.RETURN:
            assert index + 1 + max(if_true, if_false) < len(program)
