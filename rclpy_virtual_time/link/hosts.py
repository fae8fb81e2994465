"""Start hosts: the untrusted processes in which students' nodes run.

What isolates a host from the judge is in `host/sandbox`; `amounts.py` there has the figures.
"""

from __future__ import annotations

import contextlib
import itertools
import os
import socket
import subprocess
import sys
import tempfile
import threading
from collections.abc import Collection, Iterator, Sequence
from pathlib import Path

import msgspec

from rclpy_virtual_time.host.frames import Birth, Clear, Done, Fault, Furnish, Hello, Request
from rclpy_virtual_time.host.kinds import LIVE, NODES, SCRIPTS
from rclpy_virtual_time.host.sandbox.kernel_filters import NEWEST, hide_memory
from rclpy_virtual_time.host.sandbox.layers import (
    CALLS,
    FILES,
    LAYERS,
    LIMITS,
    MOUNTS,
    NETWORK,
    USER,
)
from rclpy_virtual_time.host.sandbox.users import USERS, closed_ancestor, prefer
from rclpy_virtual_time.link.errors import EngineError
from rclpy_virtual_time.link.host_process import HostProcess
from rclpy_virtual_time.link.interpreter import left_out, with_needs
from rclpy_virtual_time.link.launcher import FOREIGN_CODE
from rclpy_virtual_time.link.link import Link
from rclpy_virtual_time.link.locks import held
from rclpy_virtual_time.link.pipes import Pipes
from rclpy_virtual_time.link.real_clock import real_clock
from rclpy_virtual_time.link.ros_environment import RosEnvironment
from rclpy_virtual_time.link.settings import LEARNING, NO_GPU, SAME_RUNS
from rclpy_virtual_time.link.shared_memory import remove_half_made_ports, shared_memory_of
from rclpy_virtual_time.link.workplace import Watch, Workplace

ROOT = Path(__file__).resolve().parents[2]
LAYER_TEXTS = {
    LIMITS: "resource limits",
    USER: "a user of its own for each run",
    MOUNTS: "its own /tmp and /dev/shm",
    NETWORK: "no network",
    FILES: "no files but its own (Landlock)",
    CALLS: "no programs, processes or sockets (seccomp)",
}
VIRTUAL_DDS = {  # it never leaves the process
    "ROS_AUTOMATIC_DISCOVERY_RANGE": "OFF",
    "FASTDDS_BUILTIN_TRANSPORTS": "SHM",
}
PROFILE = ROOT / "rclpy_virtual_time" / "host" / "real_time" / "live.xml"
SILENT = "it said nothing; if the machine is very busy, try again"
SHARED_OBJECT = "shared object file"  # the dynamic linker's words for a library it can't find
FORK_SERVER_START = 60.0  # [s] for the imports of a cold machine; anew while they get on
GETS_ON = 0.1  # [s] of CPU time


def live_dds(distro: str) -> dict[str, str]:
    """Return what keeps DDS on this machine; Kilted's rmw warns of the variable's old name."""
    name = "FASTDDS" if distro == "kilted" else "FASTRTPS"
    return {
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "SYSTEM_DEFAULT",  # as the profile says
        f"{name}_DEFAULT_PROFILES_FILE": str(PROFILE),
    }


class ForkServer:
    """A warm process that forks hosts (see rclpy_virtual_time.host.forkserver).

    Parameters
    ----------
    epoch
        ROS time of a scenario's start [ns].
    libraries
        What is loaded before hosts are forked, because it takes long: modules, and types of
        messages, "sensor_msgs/msg/LaserScan".
    kind
        What its hosts run: nodes in virtual time, scripts that return, nodes in real time, or tests
        in virtual time.
    layers
        The layers of isolation that its hosts put on where the machine has them; all by default.
    landlock
        The newest version (ABI) of Landlock that they use: to see what an older kernel leaves open.
    advice
        What hosts say of their programs: a subclass of `Advice`, as "module:Class".
    workshop
        What `libraries` is, for the hosts of scripts.
    """

    practice = ""  # a grading made here is not for practice only

    def __init__(
        self,
        epoch: int,
        ros: RosEnvironment | None = None,
        *,
        libraries: Sequence[str] = (),
        kind: str = NODES,
        layers: Collection[str] = LAYERS,
        landlock: int = NEWEST,
        advice: str = "",
        workshop: Sequence[str] = (),
    ) -> None:
        hide_memory()  # from hosts that may be the same user
        self._epoch = epoch
        self._libraries = tuple(libraries)
        self._kind = kind
        self._sisters: dict[str, ForkServer] = {}  # by kind; they start when first asked for
        self.ros = ros or RosEnvironment.find()
        self._lock = threading.Lock()
        self._wanted = tuple(layers)
        self._landlock = landlock
        self._advice = advice
        self._workshop_libraries = tuple(workshop)
        self._means = Hello(())
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
        """The layers of isolation that hosts have here (see host/sandbox/layers.py)."""
        return self.means.layers

    @property
    def means(self) -> Hello:
        """What isolates hosts here."""
        self._await_ready()
        return self._means

    @property
    def foreign_code(self) -> str:
        """Why other people's code should not run here; "" if it may."""
        return "" if FILES in self.layers else FOREIGN_CODE

    @property
    def guards_files(self) -> bool:
        """Whether something keeps hosts from changing other files of this user's."""
        return FILES in self.layers or USER in self.layers

    @property
    def shares_network(self) -> bool:
        """Whether hosts are in the machine's network."""
        return NETWORK not in self.layers

    @property
    def isolation(self) -> str:
        """Say what stands between students' code and this machine."""
        return ", ".join(LAYER_TEXTS[layer] for layer in self.layers)

    @property
    def workshop(self) -> ForkServer:
        """The fork server for scripts that goes with this one."""
        return self._sister(SCRIPTS, self._workshop_libraries)

    @property
    def live(self) -> ForkServer:
        """The fork server for nodes in real time that goes with this one."""
        return self._sister(LIVE, self._libraries)

    def _sister(self, kind: str, libraries: Sequence[str]) -> ForkServer:
        with self._lock:
            if kind not in self._sisters:
                sister = ForkServer(
                    self._epoch, self.ros, libraries=libraries, kind=kind, layers=self._wanted,
                    landlock=self._landlock, advice=self._advice,
                )  # fmt: skip
                sister._users = self._users  # no two hosts are the same user
                self._sisters[kind] = sister
            return self._sisters[kind]

    @contextlib.contextmanager
    def user(self) -> Iterator[int]:
        """Hold a user [uid] for hosts that no other process on this machine has.

        0, the judge's own user, where hosts can't run as another.
        """
        if USER not in self.layers:
            yield 0
            return
        for _ in USERS:
            uid = next(self._users)
            with held(f"user/{uid}") as mine:
                if mine:
                    yield uid
                    return
        raise EngineError("no free user for a host: too many run on this machine")

    @contextlib.contextmanager
    def workplace(self, folder: Path, *, limited: bool = True) -> Iterator[Workplace]:
        """Prepare a folder for hosts, which all run as one user of their own.

        Where mounts are to be had it is `limited`: hosts work in a copy, which can't grow, and
        which is gone when the block ends.

        Raises EngineError: the machine refuses that.
        """
        with self.user() as uid:
            if uid:
                _check_open(folder)
            if not limited or MOUNTS not in self.layers:
                if uid:
                    _give(folder, uid)
                yield Workplace(folder, folder, uid)
                return
            _, descriptor = self._ask(Furnish(str(folder), uid), descriptors=())
            try:
                yield Workplace(folder, Path(f"/proc/self/fd/{descriptor}"), uid, descriptor)
            finally:
                os.close(descriptor)
                with contextlib.suppress(OSError), self._lock:  # if it is gone, so is the mount
                    self._control.sendall(msgspec.json.encode(Clear(str(folder))))

    @contextlib.contextmanager
    def host(self, place: Path | Workplace) -> Iterator[Link]:
        """Fork a host, and link it with the judge (see `host_process`)."""
        with self.host_process(place) as host:
            yield Link(Pipes(host))

    @contextlib.contextmanager
    def host_process(
        self, place: Path | Workplace, *, priority: bool = False
    ) -> Iterator[HostProcess]:
        """Fork a host that works in a place; it is dead when the block ends.

        Each host is another user, unless several share a `Workplace`. One with `priority` goes
        before others on the machine from its start on, if that is allowed.
        """
        made = self.workplace(place) if isinstance(place, Path) else contextlib.nullcontext(place)
        shared = MOUNTS not in self.layers  # the machine's /dev/shm
        with made as workplace:
            if shared:
                remove_half_made_ports()
            host = self._fork(workplace, priority)
            try:
                yield host
            finally:
                files = shared_memory_of(host.pid) if shared else []
                host.kill()
                host.reap()
                host.close()
                for file in files:
                    file.unlink(missing_ok=True)
                if shared:
                    remove_half_made_ports()

    def _command(self, control: int) -> list[str]:
        paths = [*map(str, self.ros.python_path), str(ROOT)]  # which may be site-packages
        layers = ",".join(self._wanted)
        words = (control, self._epoch, self._kind, layers, self._landlock, self._advice)
        arguments = [*map(str, words), *self._libraries]
        boot = (
            f"import sys; sys.path[:1] = {paths!r}; sys.argv[1:] = {arguments!r};"
            "from rclpy_virtual_time.host import imports; imports.host.watch();"
            f"{self.ros.prelude or 0};"
            "import runpy; runpy.run_module('rclpy_virtual_time.host', run_name='__main__')"
        )
        # -s: nothing from the user's site. Our own bytecode is kept, a node's is not (`settle`).
        return [sys.executable, "-s", "-X", "utf8", "-c", boot]

    @property
    def environment(self) -> dict[str, str]:
        """The environment variables of its hosts."""
        return {
            "PATH": "/usr/bin:/bin",
            **SAME_RUNS,
            **({} if self._kind == LIVE else NO_GPU),
            **LEARNING,
            "ROS_LOG_DIR": tempfile.gettempdir(),
            "RMW_IMPLEMENTATION": "rmw_fastrtps_cpp",
            "RCUTILS_COLORIZED_OUTPUT": "0",
            **(live_dds(self.ros.distro) if self._kind == LIVE else VIRTUAL_DDS),
            **with_needs(self.ros.variables()),
        }

    def _await_ready(self) -> None:
        with self._lock:
            if self._ready:
                return
            self._control.settimeout(FORK_SERVER_START)
            try:
                hello = msgspec.json.decode(self._hear(), type=Hello)
            except (OSError, msgspec.DecodeError) as error:
                raise EngineError(f"no host for nodes: {self._why()}") from error
            self._means = hello
            self._ready = True
            if self._kind == LIVE:  # it forks hosts while a trial in real time is running
                prefer(self._process.pid)

    def _hear(self) -> bytes:
        """Return the first words of the fork server, for which a busy machine may need minutes."""
        used = 0.0
        while True:
            try:
                return self._control.recv(4096)
            except TimeoutError:
                before, used = used, real_clock.cpu_time(self._process.pid)
                if not used - before >= GETS_ON:  # nan where the system doesn't tell
                    raise

    def _why(self) -> str:
        """Say why the fork server did not start: its last words, and what may help."""
        said = self._last_words()
        if SHARED_OBJECT in said and (folders := left_out()):
            said += (
                f"; hosts don't get {', '.join(map(str, folders))} of LD_LIBRARY_PATH, from which "
                "this Python has no library itself: start it with that library "
                "(LD_PRELOAD=…), or install it where the system looks"
            )
        return said

    def _last_words(self) -> str:
        self._log.seek(0)
        lines = self._log.read().decode("utf-8", "replace").strip().splitlines()
        return lines[-1] if lines else SILENT

    def _fork(self, place: Workplace, priority: bool) -> HostProcess:
        request = Request(str(place.folder), place.user, self.layers, priority)
        their_in, link_out = os.pipe()
        link_in, their_out = os.pipe()
        stdout, their_stdout = os.pipe()
        stderr, their_stderr = os.pipe()
        status, their_status = os.pipe()
        theirs = (their_in, their_out, their_stdout, their_stderr, their_status)
        try:
            birth, pidfd = self._ask(request, theirs)
            assert isinstance(birth, Birth)
        except EngineError:
            for fd in (link_out, link_in, stdout, stderr, status):
                os.close(fd)
            raise
        finally:
            for fd in theirs:
                os.close(fd)
        for fd in (link_out, link_in, stdout, stderr):
            os.set_blocking(fd, False)
        watch = Watch(birth.pid, place, self.means.counted)
        return HostProcess(birth.pid, pidfd, link_out, link_in, stdout, stderr, status, watch)

    def _ask(
        self, request: Request | Furnish, descriptors: Sequence[int]
    ) -> tuple[Birth | Done, int]:
        """Ask the fork server for something; return its answer and the descriptor with it."""
        self._await_ready()
        try:
            with self._lock:
                socket.send_fds(self._control, [msgspec.json.encode(request)], descriptors)
                data, fds, _, _ = socket.recv_fds(self._control, 4096, 1)
            answer = msgspec.json.decode(data, type=Birth | Done | Fault)
        except (OSError, msgspec.DecodeError) as error:
            raise EngineError(f"no host for the node: {self._last_words()}") from error
        if isinstance(answer, Fault):
            raise EngineError(f"no host for the node: {answer.text}")
        return answer, fds[0] if fds else -1


def _check_open(folder: Path) -> None:
    closed = closed_ancestor(folder.parent)
    if closed is not None:
        raise EngineError(
            f"{closed}: closed to the user that runs nodes, and holds their temporary "
            "folders; set TMPDIR to a folder that everybody can enter, such as /tmp"
        )


def _give(folder: Path, uid: int) -> None:
    for path in [folder, *folder.rglob("*")]:
        os.chown(path, uid, uid, follow_symlinks=False)
