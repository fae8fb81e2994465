"""The judge's handle on one host: its pipes and its end."""

import contextlib
import os
import select
import signal
from dataclasses import dataclass

from rclpy_virtual_time.host.frames import ENTERED, REFUSED
from rclpy_virtual_time.link.errors import EngineError
from rclpy_virtual_time.link.real_clock import real_clock
from rclpy_virtual_time.link.run_queue import is_ready
from rclpy_virtual_time.link.workplace import Watch


@dataclass
class HostProcess:
    """The judge's handle on one host: its pipes and how to end it."""

    pid: int
    pidfd: int
    link_out: int  # judge writes frames here
    link_in: int  # judge reads frames here
    stdout: int
    stderr: int
    status: int  # whether it began, and when it has ended its exit status, arrive here as text
    watch: Watch | None = None  # over what it takes of the machine
    _said: bytes = b""  # through `status`

    def kill(self) -> None:
        """End the host; the fork server ends what it started (see `_bury` there)."""
        with contextlib.suppress(ProcessLookupError):
            signal.pidfd_send_signal(self.pidfd, signal.SIGKILL)

    def is_ready(self) -> bool:
        """Return whether the host would go on if the machine let it."""
        return is_ready(self.pid)

    def dump_stacks(self, number: int = signal.SIGUSR1) -> None:
        """Ask the host to write the stacks of its threads to stderr; SIGUSR2: from native code."""
        with contextlib.suppress(ProcessLookupError):
            signal.pidfd_send_signal(self.pidfd, number)

    def wait(self, patience: float = 0.0) -> str:
        """Wait for the end of the host; return its exit status ("-9": killed by signal 9).

        After `patience` [s] it is killed: a program can close its pipes and live on.

        Raises EngineError: it has never come to the student's program, or the fork server has
        ended.
        """
        self.reap(patience)
        said = self._said.decode("utf-8", "replace").strip()
        if not self._said.endswith(b"\n"):
            raise EngineError("the process that starts hosts has ended, and the node with it")
        if not self._said.startswith(ENTERED):
            raise EngineError(f"no host for the node: {said.removeprefix(REFUSED.decode())}")
        return said[1:]

    def reap(self, patience: float = 0.0) -> None:
        """Wait for the end of the host, at most `patience` [s]; then kill it."""
        poll = select.poll()
        poll.register(self.status, select.POLLIN)
        deadline = real_clock.monotonic() + patience
        while not self._said.endswith(b"\n"):
            if not poll.poll(max(0.0, deadline - real_clock.monotonic()) * 1e3):
                self.kill()
                poll.poll()
            chunk = os.read(self.status, 4096)
            if not chunk:
                return
            self._said += chunk

    def close(self) -> None:
        """Close the judge's ends of the pipes."""
        for fd in (self.pidfd, self.link_out, self.link_in, self.stdout, self.stderr, self.status):
            os.close(fd)
