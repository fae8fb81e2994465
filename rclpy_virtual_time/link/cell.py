"""A process of its own for whatever parses what students made: archives, notebooks, Markdown.

A file can make its reader take gigabytes, hours, or the process itself. So each is read in a child
that is forked for it, behind the layers of the sandbox: an unprivileged user (for root), no files
but the one it reads and the folder it fills, no network, no programs, and limits on memory, CPU
time, files and the answer. Its end costs this file alone, with a reason. The answer is plain data,
which the caller's process decodes against a type.

A server forks the children. It has imported what they need, and holds nothing secret.
"""

from __future__ import annotations

import atexit
import contextlib
import importlib
import os
import select
import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, Literal, TypeVar

import msgspec

from rclpy_virtual_time.link.errors import DiskFull, EngineError
from rclpy_virtual_time.link.interpreter import with_needs
from rclpy_virtual_time.link.real_clock import real_clock
from rclpy_virtual_time.link.scratch import open_regular_file

MIB = 1024 * 1024
USER = 65520  # behind those of nodes (host/sandbox/users.py); systemd leaves it unused
OPEN_FILES = 64
PATIENCE = 60.0  # [s] of real time, more than SLOWNESS times the CPU time: a busy machine
GLANCE = 0.2  # [s] a Ctrl-C between Python and a poll is only seen when that returns
SLOWNESS = 5.0
SAID = 300  # [characters] of an exception
CODECS = ("cp437", "cp1252", "utf-8-sig", "utf-16", "latin-1", "iso8859-15", "idna")
BOOT = f"import sys; sys.path[:] = sys.argv[2:]; from {__name__} import serve; serve()"

T = TypeVar("T")


class Refused(Exception):
    """A file is not read; the message says why."""


class Broken(Refused):
    """The file is invalid; the message is the parser's."""


@dataclass(frozen=True)
class FileReader:
    """A process of its own for reading one file, and what that may take."""

    Refused: ClassVar = Refused
    Broken: ClassVar = Broken

    memory: int = 512 * MIB  # [bytes]
    cpu: int = 5  # [s]; the largest honest file takes a tenth on a laptop
    file: int = 101 * MIB  # [bytes] of one that it writes
    answer: int = 16 * MIB  # [bytes]

    def read(
        self,
        work: Callable[..., T],
        *arguments: Any,
        returns: Any,
        file: Path | None = None,
        room: Path | None = None,
    ) -> T:
        """Return what `work` makes of a file, in a process of its own.

        Raises Refused, Broken: the file can't be read. Its reader was ended by a limit, raised
        `Refused`, or anything.
        Raises DiskFull: no space is left.
        Raises OSError: the file can't be opened, is a link, or no ordinary file.
        Raises EngineError: no process can be made.

        Parameters
        ----------
        work
            A function of a module. It is called with `file`, open for reading, and `room`, the one
            folder it may write to, if they are given; then with `arguments`, which are plain data.
        returns
            The type of its answer.
        """
        with contextlib.ExitStack() as stack:
            opened = None if file is None else stack.enter_context(open_regular_file(file))
            if sys.platform != "linux":  # where nothing of other people's is graded
                given = (each for each in (opened, room) if each is not None)
                return _directly(work, (*given, *arguments))
            module = sys.modules[work.__module__]
            request = _Request(
                module.__spec__.name if module.__spec__ else module.__name__,  # not "__main__"
                work.__qualname__, self, file is not None, room is not None,
                msgspec.Raw(msgspec.msgpack.encode(arguments)),
            )  # fmt: skip
            fds = [] if opened is None else [opened.fileno()]
            if room is not None:
                from rclpy_virtual_time.host.sandbox import users  # noqa: PLC0415  (Linux only)

                if users.is_root():
                    os.chown(room, USER, USER)
                fds.append(os.open(room, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW))
                stack.callback(os.close, fds[-1])
            said = _servers.ask(msgspec.msgpack.encode(request), fds, self)
        value: T = _understood(said, returns)
        return value


class _Request(msgspec.Struct):
    module: str
    function: str
    limits: FileReader
    has_file: bool
    has_room: bool
    arguments: msgspec.Raw


class _Answer(msgspec.Struct):
    kind: Literal["value", "refused", "broken", "full", "fault"]
    text: str = ""
    value: msgspec.Raw = msgspec.Raw(b"\xc0")


def _directly(work: Callable[..., T], arguments: Sequence[Any]) -> T:
    try:
        return work(*arguments)
    except (Refused, OSError):
        raise
    except Exception as error:
        raise Broken(_said(error)) from None


def _understood(said: bytes, returns: Any) -> Any:
    try:
        answer = msgspec.msgpack.decode(said, type=_Answer)
        if answer.kind == "value":
            return msgspec.msgpack.decode(answer.value, type=returns)
    except (msgspec.MsgspecError, ValueError, RecursionError):
        raise Refused("its reader gave no valid answer") from None
    text = "".join(c if c.isprintable() else "?" for c in answer.text[: 2 * SAID])
    if answer.kind == "full":
        raise DiskFull(text)
    if answer.kind == "fault":
        raise EngineError(f"no file of students' can be read here: {text}")
    raise (Broken if answer.kind == "broken" else Refused)(text)


# --- the caller's side ---------------------------------------------------------------------------


class _Servers:
    """The server of this process; it starts when first asked, and again after an accident."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._process: subprocess.Popen[bytes] | None = None
        self._control: socket.socket | None = None
        self._owner = 0  # process that started it; a fork has none

    def ask(self, request: bytes, fds: Sequence[int], limits: FileReader) -> bytes:
        """Return the answer of a child."""
        with self._lock:
            try:
                control = self._started()
                return self._asked(control, request, fds, limits)
            except Refused:
                raise
            except BaseException as error:  # Ctrl-C too: what runs is of no use
                self.close()
                if isinstance(error, OSError):
                    why = f"students' files can't be read here ({error.strerror})"
                    raise EngineError(why) from error
                raise

    def _asked(
        self, control: socket.socket, request: bytes, fds: Sequence[int], limits: FileReader
    ) -> bytes:
        ours, theirs = os.pipe()
        try:
            head = len(request).to_bytes(8, "little")
            try:
                socket.send_fds(control, [head], [*fds, theirs])
            finally:
                os.close(theirs)
            control.sendall(request)
            said = self._answer(ours, limits)
            status = int.from_bytes(_exactly(control, 4), "little")
        finally:
            os.close(ours)
        if os.WIFSIGNALED(status):
            raise Refused(_death(os.WTERMSIG(status), limits))
        return said

    def _answer(self, pipe: int, limits: FileReader) -> bytes:
        """Read to the end, at most as much and as long as may be."""
        deadline = real_clock.monotonic() + PATIENCE + SLOWNESS * limits.cpu
        ready = select.poll()
        ready.register(pipe, select.POLLIN)
        said = bytearray()
        while len(said) <= limits.answer:
            left = deadline - real_clock.monotonic()
            if left <= 0.0:
                self.close()
                raise Refused(f"reading it takes more than {PATIENCE + SLOWNESS * limits.cpu:g} s")
            if not ready.poll(1e3 * min(left, GLANCE)):
                continue
            chunk = os.read(pipe, MIB)
            if not chunk:
                return bytes(said)
            said += chunk
        self.close()
        raise Refused(f"there is more in it than the {limits.answer // MIB} MiB that are read")

    def _started(self) -> socket.socket:
        if self._owner != os.getpid():
            self._process = self._control = None  # another process's
        if self._control is None or self._process is None or self._process.poll() is not None:
            self.close()
            self._control, theirs = socket.socketpair()
            paths = [os.path.abspath(path) for path in sys.path]  # noqa: PTH100
            with theirs:
                self._process = subprocess.Popen(
                    [sys.executable, "-I", "-B", "-c", BOOT, str(theirs.fileno()), *paths],
                    pass_fds=[theirs.fileno()], env=with_needs({}), cwd="/",
                    stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                    stderr=subprocess.DEVNULL, start_new_session=True,  # Ctrl-C is for us
                )  # fmt: skip
            self._owner = os.getpid()
        return self._control

    def close(self) -> None:
        """End the server, and with it the child that it waits for."""
        if self._owner != os.getpid():
            return
        if self._control is not None:
            self._control.close()
        if self._process is not None:
            self._process.kill()
            self._process.wait()
        self._process = self._control = None


_servers = _Servers()
atexit.register(_servers.close)


def _death(number: int, limits: FileReader) -> str:
    if number in (signal.SIGXCPU, signal.SIGKILL):
        return f"reading it takes more than {limits.cpu} s of CPU time"
    if number == signal.SIGXFSZ:
        return f"it unpacks to a file of more than {limits.file // MIB} MiB"
    return f"reading it ends its reader ({signal.Signals(number).name})"


def _said(error: BaseException) -> str:
    text = f"{type(error).__name__}: {error}".encode("utf-8", "replace").decode()
    return " ".join(text[:SAID].split()).rstrip(": ")


# --- the server ----------------------------------------------------------------------------------


def serve() -> None:
    """Fork a child for each request, until the caller is gone."""
    from rclpy_virtual_time.host.sandbox import kernel_filters, limits, users  # noqa: F401, PLC0415

    for codec in CODECS:
        "".encode(codec)  # children import nothing
    control = socket.socket(fileno=int(sys.argv[1]))
    while True:
        head, fds, *_ = socket.recv_fds(control, 8, 3)
        if not head:
            return
        try:
            head += _exactly(control, 8 - len(head)) if len(head) < 8 else b""
            body = _exactly(control, int.from_bytes(head, "little"))
            pid = _forked(control, body, fds)
        finally:
            for fd in fds:
                os.close(fd)
        del body
        _, status = os.waitpid(pid, 0)
        control.sendall(status.to_bytes(4, "little"))


def _forked(control: socket.socket, body: bytes, fds: list[int]) -> int:
    request = msgspec.msgpack.decode(body, type=_Request)
    if request.module not in sys.modules:
        module = importlib.import_module(request.module)
        getattr(module, "warm_up", lambda: None)()
    work = getattr(sys.modules[request.module], request.function)
    server = os.getpid()
    pid = os.fork()
    if pid == 0:
        try:
            control.close()
            _answer(work, request, fds, server)
        finally:
            os._exit(1)
    return pid


def _answer(work: Callable[..., Any], request: _Request, fds: list[int], server: int) -> None:
    *given, pipe = fds
    try:
        _enter(request.limits, given[-1] if request.has_room else None, server)
    except Exception as error:
        _write(pipe, _Answer("fault", _said(error)))
        return
    try:
        arguments: list[Any] = msgspec.msgpack.decode(request.arguments)
        if request.has_room:
            arguments.insert(0, Path())
        if request.has_file:
            arguments.insert(0, open(given[0], "rb", closefd=False))  # noqa: SIM115
        value = msgspec.Raw(msgspec.msgpack.encode(work(*arguments)))
        answer = _Answer("value", "", value)
    except MemoryError:
        answer = _Answer("refused", f"reading it takes more than {request.limits.memory // MIB} "
                                    "MiB of memory")  # fmt: skip
    except Refused as error:
        kind: Literal["broken", "refused"] = "broken" if isinstance(error, Broken) else "refused"
        answer = _Answer(kind, str(error).encode("utf-8", "replace").decode()[: 2 * SAID])
    except Exception as error:  # whatever a malicious file makes a parser raise
        answer = _Answer("full" if DiskFull.caused(error) else "broken", _said(error))
    _write(pipe, answer)
    os._exit(0)


def _enter(limits: FileReader, room: int | None, server: int) -> None:
    """Put on the layers of the sandbox, and the limits."""
    import resource  # noqa: PLC0415  (Linux only, as all of the sandbox)

    from rclpy_virtual_time.host.sandbox import kernel_filters, users  # noqa: PLC0415
    from rclpy_virtual_time.host.sandbox.limits import die_first  # noqa: PLC0415

    if room is None:
        os.chdir("/")
    else:
        os.fchdir(room)
    for limit, value in (
        (resource.RLIMIT_CORE, 0),
        (resource.RLIMIT_NOFILE, OPEN_FILES),
        (resource.RLIMIT_FSIZE, limits.file),
        (resource.RLIMIT_DATA, limits.memory),
    ):
        resource.setrlimit(limit, (value, value))
    resource.setrlimit(resource.RLIMIT_CPU, (limits.cpu, limits.cpu + 1))
    die_first()
    if users.is_root():
        users.drop_to(USER)
    else:
        users.drop_capabilities()
    kernel_filters.die_with_parent(server)
    if kernel_filters.landlock_abi():
        kernel_filters.restrict_files([], [] if room is None else [Path()])
    if kernel_filters.has_seccomp():
        kernel_filters.restrict_calls(reserving=False)


def _write(pipe: int, answer: _Answer) -> None:
    left = memoryview(msgspec.msgpack.encode(answer))
    while left:
        left = left[os.write(pipe, left) :]


def _exactly(control: socket.socket, size: int) -> bytes:
    found = bytearray()
    while len(found) < size:
        chunk = control.recv(min(MIB, size - len(found)))
        if not chunk:
            raise OSError(0, "a reader's server has ended")
        found += chunk
    return bytes(found)
