"""What the kernel keeps a process from, each rule by itself, in children that put it on."""

import ctypes
import errno
import faulthandler
import os
import platform
import resource
import select
import signal
import socket
import threading
from collections.abc import Callable
from pathlib import Path

import pytest

from grader.host.sandbox import kernel_filters as sandbox
from grader.host.sandbox.kernel_filters import CALLS, PRETENDED, X32_BIT

X86 = platform.machine() == "x86_64"
COLUMN = 0 if X86 else 1
libc = ctypes.CDLL(None, use_errno=True)

filters = pytest.mark.skipif(not sandbox.has_seccomp(), reason="this kernel has no seccomp filters")
landlock = pytest.mark.skipif(not sandbox.landlock_abi(), reason="this kernel has no Landlock")
x86_only = pytest.mark.skipif(not X86, reason="only x86_64 has these calls")


def in_child(body: Callable[[], object], limit: float = 20.0) -> str:
    """Run a function in a forked child; return what it returns, as text, or how it ended."""
    said, says = os.pipe()
    pid = os.fork()
    if pid == 0:
        try:
            os.close(said)
            os.write(says, repr(body()).encode()[:60_000])
        except BaseException as error:
            os.write(says, f"{type(error).__name__}: {error}".encode()[:60_000])
        finally:
            os._exit(0)
    os.close(says)
    with os.fdopen(said, "rb") as answer:
        if not select.select([answer], [], [], limit)[0]:
            os.kill(pid, signal.SIGKILL)
        text = answer.read().decode()
    _, status = os.waitpid(pid, 0)
    return text or f"exit status {os.waitstatus_to_exitcode(status)}"


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


def confined(
    body: Callable[[], object], read: tuple[Path, ...] = (), write: tuple[Path, ...] = ()
) -> str:
    """Run a function in a child behind Landlock."""

    def run() -> object:
        sandbox.restrict_files(read, write)
        return body()

    return in_child(run)


def error_of(body: Callable[[], object]) -> str:
    """Return the name of the error that a function ends with; "fine" if none."""
    try:
        body()
    except OSError as error:
        return errno.errorcode[error.errno or 0]
    return "fine"


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
        import mmap  # noqa: PLC0415

        page = mmap.mmap(-1, 4096, prot=mmap.PROT_READ | mmap.PROT_WRITE | mmap.PROT_EXEC)
        page.write(code)
        address = ctypes.addressof(ctypes.c_char.from_buffer(page))
        return int(ctypes.CFUNCTYPE(ctypes.c_int)(address)())

    assert filtered(run) in (f"exit status {-signal.SIGSYS}", f"exit status {-signal.SIGSEGV}")


@filters
def test_no_processes_and_no_programs() -> None:
    ways = {
        "fork": os.fork,
        "exec": lambda: os.execv("/bin/true", ["true"]),
        "spawn": lambda: os.posix_spawn("/bin/true", ["true"], {}),
    }
    for name, way in ways.items():
        assert filtered(lambda way=way: error_of(way)) == "'EPERM'", name


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
def test_signals_go_to_the_process_itself_only() -> None:
    parent = os.getpid()

    def itself() -> list[int]:
        got: list[int] = []
        signal.signal(signal.SIGUSR1, lambda number, _: got.append(number))
        os.kill(os.getpid(), signal.SIGUSR1)
        signal.raise_signal(signal.SIGUSR1)
        return [int(number) for number in got]

    assert filtered(itself) == repr([int(signal.SIGUSR1)] * 2)
    for target in (parent, 1, 0, -1, -parent):
        assert filtered(lambda target=target: error_of(lambda: os.kill(target, 0))) == "'EPERM'"

    def abort() -> None:
        faulthandler.disable()
        os.abort()

    assert filtered(abort) == f"exit status {-signal.SIGABRT}"


@filters
def test_pipes_send_no_signals() -> None:
    import fcntl  # noqa: PLC0415

    def own(command: int) -> str:
        ours, _ = os.pipe()
        return error_of(lambda: fcntl.fcntl(ours, command, os.getpid()))

    for command in (fcntl.F_SETOWN, fcntl.F_SETSIG, fcntl.F_NOTIFY):
        assert filtered(lambda command=command: own(command)) == "'EPERM'"
    assert filtered(lambda: own(fcntl.F_SETFL)) == "'fine'"
    assert filtered(lambda: error_of(lambda: fcntl.flock(os.open(".", 0), fcntl.LOCK_EX))) in (
        "'fine'",
        "'EBADF'",
    )


@filters
def test_limits_of_its_own_only() -> None:
    parent = os.getpid()
    core = resource.RLIMIT_CORE
    assert filtered(lambda: error_of(lambda: resource.setrlimit(core, (0, 0)))) == "'fine'"
    said = filtered(lambda: error_of(lambda: resource.prlimit(parent, core, (0, 0))))
    assert said == "'EPERM'"


SOCKETS = {
    "TCP": (socket.AF_INET, socket.SOCK_STREAM, 0),
    "TCP, not blocking": (socket.AF_INET, socket.SOCK_STREAM | socket.SOCK_NONBLOCK, 0),
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
def test_datagrams_arrive_and_connections_do_not() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]

        def talk() -> bytes:
            ours = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
            ours.bind(("127.0.0.1", 0))
            ours.settimeout(5)
            ours.sendto(b"x", ours.getsockname())
            return ours.recv(1)

        assert filtered(talk, datagrams=True) == repr(b"x")
        said = filtered(
            lambda: error_of(lambda: socket.create_connection(("127.0.0.1", port), 1)),
            datagrams=True,
        )
        assert said == "'EPERM'"


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
    program = sandbox._filter(datagrams)

    assert len(program) < 4_096
    assert program[-1] == (sandbox.RETURN, 0, 0, sandbox.ALLOW)
    for index, (code, if_true, if_false, _) in enumerate(program):
        if code != sandbox.RETURN:
            assert index + 1 + max(if_true, if_false) < len(program)


# --- files ---------------------------------------------------------------------------------------


@pytest.fixture
def places(tmp_path: Path) -> dict[str, Path]:
    """A folder to write in, one to read, one that is neither; a file in each."""
    found = {}
    for name in ("own", "library", "closed"):
        folder = tmp_path / name
        folder.mkdir()
        (folder / "file").write_text(name)
        (folder / "program").write_text("#!/bin/sh\n")
        (folder / "program").chmod(0o755)
        found[name] = folder
    return found


def try_in(places: dict[str, Path], body: Callable[[], object]) -> str:
    return confined(lambda: error_of(body), (places["library"],), (places["own"],)).strip("'")


@landlock
def test_reading(places: dict[str, Path]) -> None:
    for name, wanted in (("own", "fine"), ("library", "fine"), ("closed", "EACCES")):
        folder = places[name]
        assert try_in(places, (folder / "file").read_text) == wanted
        assert try_in(places, lambda folder=folder: os.listdir(folder)) == wanted


@landlock
@pytest.mark.parametrize("name", ["library", "closed"])
def test_writing_outside(places: dict[str, Path], name: str) -> None:
    folder = places[name]
    ways: dict[str, Callable[[], object]] = {
        "write": lambda: (folder / "file").write_text("mine"),
        "append": lambda: os.open(folder / "file", os.O_WRONLY | os.O_APPEND),
        "create": (folder / "new").touch,
        "remove": (folder / "file").unlink,
        "make a folder": (folder / "new").mkdir,
        "make a link": lambda: (folder / "new").symlink_to("file"),
        "make a pipe": lambda: os.mkfifo(folder / "new"),
        "rename": lambda: (folder / "file").rename(folder / "new"),
        "move out": lambda: (folder / "file").rename(places["own"] / "new"),
        "move in": lambda: (places["own"] / "file").rename(folder / "new"),
        "link out": lambda: os.link(folder / "file", places["own"] / "new"),
    }
    for way, body in ways.items():
        assert try_in(places, body) in ("EACCES", "EXDEV"), way
    assert (folder / "file").read_text() == name


@landlock
@pytest.mark.skipif(sandbox.landlock_abi() < 3, reason="this kernel's Landlock lets files be cut")
def test_truncating(places: dict[str, Path]) -> None:
    for name, wanted in (("own", "fine"), ("library", "EACCES"), ("closed", "EACCES")):
        assert try_in(places, lambda name=name: os.truncate(places[name] / "file", 0)) == wanted


@landlock
def test_its_own_folder_is_its_own(places: dict[str, Path]) -> None:
    own = places["own"]

    def work() -> None:
        (own / "file").write_text("new")
        (own / "folder").mkdir()
        (own / "file").rename(own / "folder" / "file")
        (own / "link").symlink_to("folder/file")
        assert (own / "link").read_text() == "new"
        (own / "folder" / "file").unlink()

    assert try_in(places, work) in ("fine", "EXDEV")  # before ABI 2 no move between folders


@landlock
def test_running_programs(places: dict[str, Path]) -> None:
    """Also a program that may be read, or that the process has written."""
    for folder in (*places.values(), Path("/bin")):
        program = folder / ("true" if folder == Path("/bin") else "program")
        assert try_in(places, lambda program=program: os.execv(program, ["x"])) == "EACCES"


@landlock
def test_links_lead_nowhere(places: dict[str, Path]) -> None:
    own, closed = places["own"], places["closed"]
    (own / "link").symlink_to(closed / "file")
    (own / "folder").symlink_to(closed)

    assert try_in(places, (own / "link").read_text) == "EACCES"
    assert try_in(places, (own / "folder" / "file").read_text) == "EACCES"
    assert try_in(places, lambda: (own / "folder" / "new").write_text("x")) == "EACCES"
    assert try_in(places, Path(f"{own}/../closed/file").read_text) == "EACCES"
    assert try_in(places, Path(f"/proc/self/root{closed}/file").read_text) == "EACCES"


@landlock
def test_a_single_file_can_be_shown(places: dict[str, Path]) -> None:
    file = places["closed"] / "file"
    assert confined(file.read_text, read=(file,)) == "'closed'"
    said = confined(lambda: error_of((places["closed"] / "program").read_text), read=(file,))
    assert said == "'EACCES'"


@landlock
def test_what_is_not_there_needs_no_rule(places: dict[str, Path], tmp_path: Path) -> None:
    said = confined((places["own"] / "file").read_text, (tmp_path / "no",), (places["own"],))
    assert said == "'own'"


@landlock
def test_files_stay_restricted(places: dict[str, Path]) -> None:
    def loosen() -> str:
        sandbox.restrict_files([Path("/")], [Path("/")])
        return error_of((places["closed"] / "file").read_text)

    assert confined(loosen, write=(places["own"],)) == "'EACCES'"


@landlock
@pytest.mark.skipif(sandbox.landlock_abi() < 4, reason="this kernel's Landlock knows no network")
def test_no_tcp() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        address = server.getsockname()
        said = confined(lambda: error_of(lambda: socket.create_connection(address, 1)))
    assert said == "'EACCES'"
    assert confined(lambda: error_of(lambda: socket.create_server(("127.0.0.1", 0)))) == "'EACCES'"


@landlock
@pytest.mark.skipif(sandbox.landlock_abi() < 6, reason="this kernel's Landlock has no scopes")
def test_no_signals_and_no_abstract_sockets() -> None:
    parent = os.getpid()
    assert confined(lambda: error_of(lambda: os.kill(parent, 0))) == "'EPERM'"
    with socket.socket(socket.AF_UNIX) as keeper:
        keeper.bind(f"\0course-test-{parent}")
        keeper.listen()

        def connect() -> None:
            socket.socket(socket.AF_UNIX).connect(f"\0course-test-{parent}")

        assert confined(lambda: error_of(connect)) == "'EPERM'"


def test_a_kernel_without_landlock_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sandbox, "landlock_abi", lambda: 0)
    with pytest.raises(OSError, match="no Landlock"):
        sandbox.restrict_files([], [])


@pytest.mark.parametrize("abi", [1, 2, 3, 4, 5])
@landlock
def test_older_kernels_get_what_they_know(
    abi: int, places: dict[str, Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    if abi > sandbox.landlock_abi():
        pytest.skip("this kernel is older still")
    monkeypatch.setattr(sandbox, "landlock_abi", lambda: abi)
    assert try_in(places, (places["closed"] / "file").read_text) == "EACCES"
    assert try_in(places, lambda: (places["own"] / "file").write_text("x")) == "fine"


# --- memory --------------------------------------------------------------------------------------


def test_a_process_can_hide_its_memory() -> None:
    def hidden() -> int:
        sandbox.hide_memory()
        return int(libc.prctl(3, 0, 0, 0, 0))  # PR_GET_DUMPABLE

    assert in_child(hidden) == "0"
