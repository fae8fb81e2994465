"""Start hosts: the untrusted processes in which students' nodes run.

This is the seam for the sandbox: whatever isolates a host from the judge belongs here and in
`grader.host.sandbox.users`.
"""

from __future__ import annotations

import contextlib
import itertools
import os
import select
import signal
import socket
import subprocess
import sys
import tempfile
import threading
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import msgspec

from grader.errors import GraderError
from grader.host.frames import Birth, Hello, Request
from grader.host.sandbox.kernel_filters import hide_memory
from grader.host.sandbox.layers import CALLS, FILES, LAYERS, LIMITS, MOUNTS, NETWORK, USER
from grader.host.sandbox.users import USERS, closed_ancestor, prefer
from grader.link.locks import held
from grader.link.ros_environment import RosEnvironment, find_ros

ROOT = Path(__file__).resolve().parents[2]
TRAINING_LIBRARIES = ("numpy", "sklearn.ensemble", "skl2onnx", "onnxruntime")
LAYER_TEXTS = {
    LIMITS: "resource limits",
    USER: "a user of its own for each run",
    MOUNTS: "its own /tmp and /dev/shm",
    NETWORK: "no network",
    FILES: "no files but its own (Landlock)",
    CALLS: "no programs, processes or sockets (seccomp)",
}
NODES, SCRIPTS, LIVE, TESTS = "nodes", "scripts", "live", "tests"  # what a fork server's hosts do
NO_GPU = {"CUDA_VISIBLE_DEVICES": ""}  # the same run on every machine
LEARNING = {  # for whoever imports Keras
    "KERAS_BACKEND": "torch",
    "KERAS_HOME": os.devnull,  # no settings read, none written
}
VIRTUAL_DDS = {  # it never leaves the process
    "ROS_AUTOMATIC_DISCOVERY_RANGE": "OFF",
    "FASTDDS_BUILTIN_TRANSPORTS": "SHM",
}
LIVE_DDS = {  # it never leaves the machine
    "ROS_AUTOMATIC_DISCOVERY_RANGE": "SYSTEM_DEFAULT",  # as the profile says
    "FASTRTPS_DEFAULT_PROFILES_FILE": str(ROOT / "grader" / "host" / "real_time" / "live.xml"),
}
FORK_SERVER_START = 60.0  # [s] for the imports of a cold machine


@dataclass
class HostProcess:
    """The judge's handle on one host: its pipes and how to end it."""

    pid: int
    pidfd: int
    link_out: int  # judge writes frames here
    link_in: int  # judge reads frames here
    stdout: int
    stderr: int
    status: int  # the exit status arrives here, as text, when the host has ended

    def kill(self) -> None:
        """End the host; the fork server ends what it started (see `_bury` there)."""
        with contextlib.suppress(ProcessLookupError):
            signal.pidfd_send_signal(self.pidfd, signal.SIGKILL)

    def dump_stacks(self) -> None:
        """Ask the host to write the stacks of its threads to stderr."""
        with contextlib.suppress(ProcessLookupError):
            signal.pidfd_send_signal(self.pidfd, signal.SIGUSR1)

    def wait(self, patience: float = 0.0) -> str:
        """Wait for the end of the host; return its exit status ("-9": killed by signal 9).

        After `patience` [s] it is killed: a program can close its pipes and live on.
        """
        poll = select.poll()
        poll.register(self.status, select.POLLIN)
        if not poll.poll(patience * 1e3):
            self.kill()
        return os.read(self.status, 16).decode("ascii", "replace")

    def close(self) -> None:
        """Close the judge's ends of the pipes."""
        for fd in (self.pidfd, self.link_out, self.link_in, self.stdout, self.stderr, self.status):
            os.close(fd)


class ForkServer:
    """A warm process that forks hosts (see grader.host.forkserver).

    Parameters
    ----------
    epoch
        ROS time of a scenario's start [ns].
    libraries
        Modules that are imported before hosts are forked, because they take long.
    kind
        What its hosts run: nodes in virtual time, scripts that return, nodes in real time, or tests
        in virtual time.
    layers
        Of isolation, those that its hosts put on if the machine has them; all by default.
    """

    def __init__(
        self,
        epoch: int,
        ros: RosEnvironment | None = None,
        *,
        libraries: Sequence[str] = (),
        kind: str = NODES,
        layers: Collection[str] = LAYERS,
    ) -> None:
        hide_memory()  # from hosts that may be the same user
        self._epoch = epoch
        self._libraries = tuple(libraries)
        self._kind = kind
        self._sisters: dict[str, ForkServer] = {}  # by kind; they start when first asked for
        self.ros = ros or find_ros()
        self._lock = threading.Lock()
        self._wanted = tuple(layers)
        self._layers: tuple[str, ...] = ()
        self._users = itertools.cycle(USERS)
        for _ in range(os.getpid() % len(USERS)):  # away from other graders on this machine
            next(self._users)
        self._ready = False
        self._control, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self._log = tempfile.TemporaryFile()  # noqa: SIM115  (closed in __exit__)
        with theirs:
            self._process = subprocess.Popen(
                self._command(theirs.fileno()),
                pass_fds=[theirs.fileno()],
                stdin=subprocess.DEVNULL,
                stdout=self._log,
                stderr=self._log,
                env=self.environment,
                cwd="/",
                start_new_session=self._kind == LIVE,  # Linux weighs CPU time by session
            )

    def __enter__(self) -> ForkServer:
        return self

    def __exit__(self, *_: object) -> None:
        for sister in self._sisters.values():
            sister.__exit__()
        self._control.close()
        try:
            self._process.wait(timeout=5)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._log.close()

    @property
    def layers(self) -> tuple[str, ...]:
        """The layers of isolation that hosts have here (see grader.host.sandbox.layers)."""
        self._await_ready()
        return self._layers

    @property
    def isolation(self) -> str:
        """Say what stands between students' code and this machine."""
        return ", ".join(LAYER_TEXTS[layer] for layer in self.layers)

    @property
    def workshop(self) -> ForkServer:
        """The fork server for scripts that goes with this one."""
        return self._sister(SCRIPTS, TRAINING_LIBRARIES)

    @property
    def live(self) -> ForkServer:
        """The fork server for nodes in real time that goes with this one."""
        return self._sister(LIVE, self._libraries)

    def _sister(self, kind: str, libraries: Sequence[str]) -> ForkServer:
        with self._lock:
            if kind not in self._sisters:
                sister = ForkServer(
                    self._epoch, self.ros, libraries=libraries, kind=kind, layers=self._wanted
                )
                sister._users = self._users  # no two hosts are the same user
                self._sisters[kind] = sister
            return self._sisters[kind]

    @contextlib.contextmanager
    def user(self) -> Iterator[int]:
        """Hold a user [uid] for hosts, which nobody else on this machine has.

        0, which stands for the judge's own, if hosts can't be another here.
        """
        self._await_ready()
        if USER not in self._layers:
            yield 0
            return
        for _ in USERS:
            uid = next(self._users)
            with held(f"user/{uid}") as mine:
                if mine:
                    yield uid
                    return
        raise GraderError("no free user for a host: too many run on this machine")

    @contextlib.contextmanager
    def host(
        self, folder: Path, user: int | None = None, *, priority: bool = False
    ) -> Iterator[HostProcess]:
        """Fork a host that works in `folder`; it is dead when the block ends.

        Each host is another user, unless several are to share their folder. One with `priority`
        goes before others on the machine from its start on, if that is allowed.
        """
        with self.user() if user is None else contextlib.nullcontext(user) as uid:
            if uid:
                _give(folder, uid)
            with self._forked(folder, uid, priority) as host:
                yield host

    @contextlib.contextmanager
    def _forked(self, folder: Path, uid: int, priority: bool) -> Iterator[HostProcess]:
        self._await_ready()
        host = self._fork(folder, uid, priority)
        try:
            yield host
        finally:
            shared_memory = [] if MOUNTS in self._layers else shared_memory_of(host.pid)
            host.kill()
            host.wait()
            host.close()
            for file in shared_memory:
                file.unlink(missing_ok=True)

    def _command(self, control: int) -> list[str]:
        paths = [str(ROOT), *map(str, self.ros.python_path)]
        layers = ",".join(self._wanted)
        arguments = [str(control), str(self._epoch), self._kind, layers, *self._libraries]
        boot = (
            f"import sys; sys.path[:0] = {paths!r}; sys.argv[1:] = {arguments!r};"
            "import runpy; runpy.run_module('grader.host', run_name='__main__')"
        )
        # -s, -B: nothing from the user's site, no files beside the sources
        return [sys.executable, "-s", "-B", "-X", "utf8", "-c", boot]

    @property
    def environment(self) -> dict[str, str]:
        """The environment variables of its hosts."""
        return {
            "PATH": "/usr/bin:/bin",
            "LANG": "C.UTF-8",
            "PYTHONHASHSEED": "0",
            "PYTHONUNBUFFERED": "1",
            "OMP_NUM_THREADS": "1",  # one thread of numeric libraries: the same sums everywhere
            "OPENBLAS_NUM_THREADS": "1",
            "LOKY_MAX_CPU_COUNT": "1",  # scikit-learn's n_jobs=-1
            **({} if self._kind == LIVE else NO_GPU),
            **LEARNING,
            "ROS_LOG_DIR": tempfile.gettempdir(),
            "RMW_IMPLEMENTATION": "rmw_fastrtps_cpp",
            "RCUTILS_CONSOLE_OUTPUT_FORMAT": "[{severity}] [{name}]: {message}",
            "RCUTILS_COLORIZED_OUTPUT": "0",
            **(LIVE_DDS if self._kind == LIVE else VIRTUAL_DDS),
            **self.ros.variables(),
        }

    def _await_ready(self) -> None:
        with self._lock:
            if self._ready:
                return
            self._control.settimeout(FORK_SERVER_START)
            try:
                hello = msgspec.json.decode(self._control.recv(4096), type=Hello)
            except (OSError, msgspec.DecodeError) as error:
                raise GraderError(f"no host for students' nodes: {self._last_words()}") from error
            self._layers = hello.layers
            self._ready = True
            if self._kind == LIVE:  # who forks a host while time counts
                prefer(self._process.pid)

    def _last_words(self) -> str:
        self._log.seek(0)
        lines = self._log.read().decode("utf-8", "replace").strip().splitlines()
        return lines[-1] if lines else "it said nothing"

    def _fork(self, folder: Path, uid: int, priority: bool) -> HostProcess:
        their_in, link_out = os.pipe()
        link_in, their_out = os.pipe()
        stdout, their_stdout = os.pipe()
        stderr, their_stderr = os.pipe()
        status, their_status = os.pipe()
        theirs = [their_in, their_out, their_stdout, their_stderr, their_status]
        request = msgspec.json.encode(Request(str(folder), uid, self._layers, priority))
        try:
            with self._lock:
                socket.send_fds(self._control, [request], theirs)
                data, fds, _, _ = socket.recv_fds(self._control, 4096, 1)
            birth = msgspec.json.decode(data, type=Birth)
        except (OSError, msgspec.DecodeError) as error:
            for fd in (link_out, link_in, stdout, stderr, status):
                os.close(fd)
            raise GraderError(f"no host for the node: {self._last_words()}") from error
        finally:
            for fd in theirs:
                os.close(fd)
        for fd in (link_out, link_in, stdout, stderr):
            os.set_blocking(fd, False)
        return HostProcess(birth.pid, fds[0], link_out, link_in, stdout, stderr, status)


def _give(folder: Path, uid: int) -> None:
    closed = closed_ancestor(folder.parent)
    if closed is not None:
        raise GraderError(
            f"{closed}: closed to the user that runs students' nodes, and holds their temporary "
            "folders; set TMPDIR to a folder that everybody can enter, such as /tmp"
        )
    for path in [folder, *folder.rglob("*")]:
        os.chown(path, uid, uid, follow_symlinks=False)


def shared_memory_of(pid: int) -> list[Path]:
    """Return the shared memory files of Fast DDS, which a killed process leaves behind."""
    try:
        maps = Path(f"/proc/{pid}/maps").read_text()
    except OSError:
        return []
    names = {
        line.split(maxsplit=5)[5] for line in maps.splitlines() if "/dev/shm/fastrtps_" in line
    }
    files = {Path(name.removesuffix(" (deleted)")) for name in names}
    return sorted(files | {file.with_name(f"{file.name}_el") for file in files})
