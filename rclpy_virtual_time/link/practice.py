"""Hosts without Linux's means: one fresh process for each trial, pipes that threads read.

Nothing keeps such a host from anything that its user may do: it is for one's own code on one's own
machine. What it says is believed as little as what any host says, but it could say it in the
judge's place; a grading made here is for practice, and says so.
"""

from __future__ import annotations

import contextlib
import os
import queue
import signal
import subprocess
import sys
import tempfile
import threading
from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import IO, ClassVar

import msgspec

from rclpy_virtual_time.host.frames import LENGTH, MAX_FRAME, Request
from rclpy_virtual_time.host.kinds import NODES, SCRIPTS
from rclpy_virtual_time.link.errors import EngineError, NoRos
from rclpy_virtual_time.link.exchange import STARVED, Cost, HostDied, HostForged, HostHung
from rclpy_virtual_time.link.launcher import FOREIGN_CODE
from rclpy_virtual_time.link.link import Link
from rclpy_virtual_time.link.log import LogLine
from rclpy_virtual_time.link.output import MAX_OUTPUT, Output, in_order
from rclpy_virtual_time.link.real_clock import real_clock
from rclpy_virtual_time.link.ros_environment import RosEnvironment
from rclpy_virtual_time.link.run_queue import is_ready
from rclpy_virtual_time.link.settings import IN_BROWSER, LEARNING, NO_GPU, SAME_RUNS
from rclpy_virtual_time.link.workplace import Workplace

ROOT = Path(__file__).resolve().parents[2]
PRACTICE = "practice: your instructor's grade comes from the real rclpy on Linux"
NO_ISOLATION = "none: the node may do what you may do"
PRELUDE = ""  # Python that a host runs before anything else; tests take Linux's means away here
PATROL = 0.1  # [s] after which the judge looks again at a host that is late
START = 120.0  # [s] for the imports of a cold machine
MOST_PRINTED = 64 * MAX_OUTPUT  # [bytes] after which a host is ended
KEPT = (  # of this process's environment: what programs need to run at all
    "PATH", "SYSTEMROOT", "SYSTEMDRIVE", "WINDIR", "PATHEXT", "COMSPEC", "NUMBER_OF_PROCESSORS",
    "PROCESSOR_ARCHITECTURE", "DYLD_LIBRARY_PATH", "LD_LIBRARY_PATH",
)  # fmt: skip
SETTINGS = {
    **SAME_RUNS,
    **NO_GPU,
    **LEARNING,
    "ROS_DISTRO": "jazzy",
    "ROS_AUTOMATIC_DISCOVERY_RANGE": "OFF",
    "_ROS_WHEELS_BOOTSTRAP_COMPLETE": "1",  # where ROS's wheels are installed, too
}


class PracticeServer:
    """Starts hosts; a spare host is always starting, so the next trial need not wait for imports.

    Its parameters are those of `ForkServer`; it has hosts for nodes in virtual time, and scripts.
    """

    layers: tuple[str, ...] = ()  # of isolation
    isolation = NO_ISOLATION
    practice = PRACTICE
    foreign_code = FOREIGN_CODE
    guards_files = False
    IN_BROWSER: ClassVar = IN_BROWSER  # `isolation` of hosts in a page
    # settings of programs that import Keras, here and beside
    SAME_RUNS: ClassVar = {**SAME_RUNS, **NO_GPU, **LEARNING}

    def __init__(
        self,
        epoch: int,
        *,
        libraries: Sequence[str] = (),
        kind: str = NODES,
        advice: str = "",
        workshop: Sequence[str] = (),
    ) -> None:
        self._arguments = [kind, str(epoch), advice, *libraries]
        self._epoch = epoch
        self._kind = kind
        self._advice = advice
        self._workshop_libraries = tuple(workshop)
        self.ros = RosEnvironment.portable()
        self.practice = PracticeServer.words()
        self._lock = threading.Lock()
        self._ready: deque[PracticeHost] = deque()
        self._workshop: PracticeServer | None = None
        self._prepare()

    def __enter__(self) -> PracticeServer:
        return self

    def __exit__(self, *_: object) -> None:
        if self._workshop is not None:
            self._workshop.__exit__()
        while self._ready:
            self._ready.pop().close()

    @staticmethod
    def why_needed(*, portable: bool = False) -> str:
        """Say why a fork server can't be used here; "" if it can. `portable`: it needs no ROS 2."""
        if sys.platform == "linux" and not hasattr(os, "pidfd_open"):
            return "this Python was built without os.pidfd_open, as before Linux 5.3: take another"
        if not (hasattr(os, "fork") and hasattr(os, "pidfd_open") and hasattr(signal, "SIGUSR1")):
            return f"the launcher for the real rclpy is for Linux, and this is {sys.platform}"
        try:
            if not portable:
                RosEnvironment.find()
        except NoRos as error:
            return str(error)
        return ""

    @staticmethod
    def words() -> str:
        """Say that it is practice, and why where a ROS 2 is here all the same."""
        try:
            RosEnvironment.find()
        except NoRos as error:
            if error.here:
                return f"{error.here} is here; this is Jazzy's portable copy, for {PRACTICE}"
        return PRACTICE

    @property
    def workshop(self) -> PracticeServer:
        """The server of hosts for scripts that goes with this one."""
        with self._lock:
            if self._workshop is None:
                self._workshop = PracticeServer(
                    self._epoch,
                    libraries=self._workshop_libraries,
                    kind=SCRIPTS,
                    advice=self._advice,
                )
            return self._workshop

    @contextlib.contextmanager
    def workplace(self, folder: Path) -> Iterator[Workplace]:
        """Return the folder unchanged: without isolation, no preparation is needed."""
        yield Workplace(folder, folder, 0)

    @contextlib.contextmanager
    def host(self, place: Path | Workplace) -> Iterator[Link]:
        """Start a host that works in a folder; it is dead when the block ends."""
        folder = place.folder if isinstance(place, Workplace) else place
        with self._lock:
            host = self._ready.popleft() if self._ready else self._started()
            self._prepare()
        try:
            host.begin(folder)
            yield Link(host)
        finally:
            host.close()

    def _prepare(self) -> None:
        self._ready.append(self._started())

    def _started(self) -> PracticeHost:
        paths = [*map(str, self.ros.python_path), str(ROOT)]  # which may be site-packages
        boot = (
            f"import sys; sys.path[:1] = {paths!r}; sys.argv[1:1] = {self._arguments!r}\n"
            "from rclpy_virtual_time.host import imports; imports.host.watch()\n"
            f"{PRELUDE}\n"
            f"{self.ros.prelude if self._kind == NODES else 0}\n"
            "from rclpy_virtual_time.host import practice; practice.serve(*sys.argv[1:])"
        )
        # -s: nothing from the user's site. Our own bytecode is kept, a node's is not (`settle`).
        return PracticeHost([sys.executable, "-s", "-X", "utf8", "-c", boot], _environment())


def _environment() -> dict[str, str]:
    kept = {name: os.environ[name] for name in KEPT if name in os.environ}
    return {**kept, **SETTINGS}


class PracticeHost:
    """One process, and threads that read and write its pipes: no read of ours waits for ever."""

    def __init__(self, command: Sequence[str], environment: Mapping[str, str]) -> None:
        self._printed = Path(tempfile.mkdtemp(prefix=f"course-{os.getpid()}-"))
        self._files = {n: self._printed / n for n in ("stdout", "stderr")}
        self.stdout, self.stderr = map(Output, self._files)
        with self._files["stderr"].open("wb") as stderr:
            self._process = subprocess.Popen(
                [*command, *map(str, self._files.values())],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=stderr,
                env=dict(environment),
                cwd=self._printed,
            )
        # opened before the node is there, which may put a pipe or a link in a file's place
        self._files["stdout"].touch()
        self._ours = {n: path.open("rb") for n, path in self._files.items()}
        assert self._process.stdin is not None and self._process.stdout is not None
        self._said: queue.Queue[bytes | HostForged | None] = queue.Queue()
        self._orders: queue.Queue[bytes | None] = queue.Queue()
        for pipe, work in ((self._process.stdout, self._read), (self._process.stdin, self._write)):
            threading.Thread(target=work, args=(pipe,), daemon=True).start()

    def begin(self, folder: Path) -> None:
        """Wait until the host has done its imports; let it work in a folder.

        Raises EngineError: it could not start.
        """
        try:
            self._receive(START)
        except (HostDied, HostHung, HostForged) as error:
            raise EngineError(f"no host for the node: {self._last_words()}") from error
        body = msgspec.json.encode(Request(str(folder), 0, ()))
        self._orders.put(LENGTH.pack(len(body)) + body)

    def expect_silence(self) -> None:
        """Make sure that the host has not answered before the question."""
        if not self._said.empty():
            self._receive(0.0)  # the end of the process is no answer
            raise HostForged("an answer before the question")

    def exchange(self, data: bytes, limit: float) -> tuple[bytes, Cost]:
        """Send a frame; return the body of the answer (see `Transport`)."""
        begun, cpu = real_clock.perf_counter(), self._cpu()
        self._orders.put(data)
        body = self._receive(limit)
        return body, Cost.uncounted(real_clock.perf_counter() - begun, self._cpu() - cpu)

    def read_output(self) -> None:
        """Read the host's output, up to `MOST_PRINTED`; HostForged if there is more."""
        for output in (self.stdout, self.stderr):
            file = self._ours[output.stream]
            if os.fstat(file.fileno()).st_size > MOST_PRINTED:
                raise HostForged(f"more than {MOST_PRINTED:,} bytes of output")
            while data := file.read(MAX_OUTPUT):
                output.feed(data)

    def log(self) -> tuple[LogLine, ...]:
        """Return the host's output so far, in order of time."""
        self.read_output()
        return in_order(self.stdout, self.stderr)

    def stacks(self) -> str:
        """Return nothing: stacks need signals, which not every system has."""
        return ""

    def wait(self, patience: float = 0.0) -> str:
        """Wait for the host's end, killing it after `patience` [s]; return its exit status."""
        try:
            return str(self._process.wait(patience))
        except subprocess.TimeoutExpired:
            self._process.kill()
            return str(self._process.wait())

    def close(self) -> None:
        """End the host, and remove what is left of it."""
        self.wait()
        self._orders.put(None)
        for name, path in self._files.items():
            self._ours[name].close()
            with contextlib.suppress(OSError):
                path.unlink()
        with contextlib.suppress(OSError):
            self._printed.rmdir()

    def _receive(self, limit: float) -> bytes:
        """Return the body of the next frame, after `limit` [s] at most.

        On a busy machine later: a host that gets on, or would, has the limit in CPU time.
        """
        begun, cpu, timeout = real_clock.perf_counter(), self._cpu(), max(limit, 0.0)
        before = cpu
        while True:
            try:
                said = self._said.get(timeout=timeout)
                break
            except queue.Empty:
                timeout, before, seen = PATROL, self._cpu(), before
                starved = before > seen or is_ready(self._process.pid)
                late = real_clock.perf_counter() - begun > STARVED * limit
                if not starved or before - cpu >= limit or late:
                    raise HostHung("") from None
        if isinstance(said, HostForged):
            raise said
        if said is None:
            raise HostDied
        return said

    def _cpu(self) -> float:
        return real_clock.cpu_time(self._process.pid)

    def _read(self, pipe: IO[bytes]) -> None:
        with pipe:
            while len(head := pipe.read(LENGTH.size)) == LENGTH.size:
                (length,) = LENGTH.unpack(head)
                if length > MAX_FRAME:
                    self._said.put(HostForged(f"a frame of {length} bytes"))
                    return
                body = pipe.read(length)
                if len(body) < length:
                    break
                self._said.put(body)
        self._said.put(None)

    def _write(self, pipe: IO[bytes]) -> None:
        with contextlib.suppress(OSError), pipe:
            while (data := self._orders.get()) is not None:
                pipe.write(data)
                pipe.flush()

    def _last_words(self) -> str:
        lines = self._ours["stderr"].read().decode("utf-8", "replace").strip().splitlines()
        return lines[-1] if lines else "it said nothing"
