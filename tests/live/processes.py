"""Processes that talk over DDS on loopback, and a way to wait for what they say."""

import contextlib
import json
import os
import queue
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from rclpy_virtual_time.link.hosts import live_dds
from rclpy_virtual_time.link.ros_environment import RosEnvironment

NODES = Path(__file__).parent / "nodes"
ROOT = Path(__file__).resolve().parents[2]
LIMIT = 90.0  # [s] for anything to happen, on any machine

Line = dict[str, Any]


def variables(domain: int, folder: Path) -> dict[str, str]:
    """Return the environment of a process in a DDS domain; it logs into the folder."""
    return {
        **os.environ,
        **RosEnvironment.find().variables(),
        **live_dds(RosEnvironment.find().distro),
        "ROS_DOMAIN_ID": str(domain),
        "ROS_LOG_DIR": str(folder),
        "PYTHONUNBUFFERED": "1",
        "PYTHONPATH": os.pathsep.join(map(str, RosEnvironment.find().python_path)),
    }


def hear_ctrl_c() -> None:
    """Take back that a shell's background jobs, and what they start, ignore SIGINT."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


class Process:
    """A program whose lines are heard as they come."""

    def __init__(self, command: list[str], env: dict[str, str], folder: Path) -> None:
        self.popen = subprocess.Popen(
            [sys.executable, *command],
            env=env,
            cwd=folder,
            text=True,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            preexec_fn=hear_ctrl_c,  # noqa: PLW1509  (it only sets a handler)
        )
        self.said: list[str] = []
        self._lines: queue.Queue[str | None] = queue.Queue()
        self._listening = threading.Thread(target=self._listen, daemon=True)
        self._listening.start()

    def wait_for(self, text: str) -> str:
        """Return the next line with this text in it."""
        return self.next_line(lambda line: text in line, text)

    def next_line(self, wanted: Callable[[str], bool], what: str) -> str:
        while True:
            try:
                line = self._lines.get(timeout=LIMIT)
            except queue.Empty:
                line = None
            assert line is not None, f"expected {what!r}, heard only:\n{''.join(self.said)}"
            if wanted(line):
                return line

    def next_json(self, topic: str, wanted: Callable[[Line], bool] = lambda _: True) -> Line:
        """Return the next message on a topic that is wanted; what comes before it is dropped."""

        def fits(line: str) -> bool:
            if not line.startswith("{"):
                return False
            message = json.loads(line)
            return message["topic"] == topic and wanted(message)

        found: Line = json.loads(self.next_line(fits, f"a wanted message on {topic}"))
        return found

    def ask(self, order: str) -> Line:
        """Give an order on stdin and return the answer."""
        assert self.popen.stdin
        self.popen.stdin.write(f"{order}\n")
        self.popen.stdin.flush()
        return self.next_json("answer")

    def end(self, number: int = signal.SIGINT) -> int:
        """Send a signal and return the exit code."""
        self.popen.send_signal(number)
        return self.popen.wait(LIMIT)

    def rest(self) -> str:
        """Return all that it said, once it has ended."""
        self.popen.wait(LIMIT)
        self._listening.join(LIMIT)
        return "".join(self.said)

    def kill(self) -> None:
        """End it, however it is."""
        self.popen.kill()
        self.rest()
        for pipe in (self.popen.stdin, self.popen.stdout):
            if pipe:
                pipe.close()

    def _listen(self) -> None:
        assert self.popen.stdout
        for line in self.popen.stdout:
            self.said.append(line)
            self._lines.put(line)
        self._lines.put(None)


class Town:
    """Processes in one DDS domain."""

    def __init__(self, domain: int, folder: Path, stack: contextlib.ExitStack) -> None:
        self.folder, self._stack = folder, stack
        self._env = variables(domain, folder)

    def robot(self, *arguments: str) -> Process:
        process = self._start(["-m", "sim", *arguments])
        process.wait_for("Ctrl+C ends")
        return process

    def teleop(self, linear: float, angular: float, *words: str) -> Process:
        return self.start("teleop.py", str(linear), str(angular), *words)

    def listener(self, reliability: str = "reliable") -> Process:
        return self.start("listener.py", reliability)

    def start(self, node: str, *arguments: str) -> Process:
        return self._start([str(NODES / node), *arguments])

    def _start(self, command: list[str]) -> Process:
        process = Process(command, self._env, self.folder)
        self._stack.callback(process.kill)
        return process


@contextlib.contextmanager
def town(domain: int, folder: Path) -> Iterator[Town]:
    """Let processes live in a domain until the block ends."""
    with contextlib.ExitStack() as stack:
        yield Town(domain, folder, stack)
