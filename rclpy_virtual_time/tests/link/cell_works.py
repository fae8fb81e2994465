"""What is done in a reader's cell, by tests: each tries what no parser should."""

import ctypes
import os
import socket
import subprocess
from pathlib import Path
from typing import IO

from rclpy_virtual_time.link.cell import Refused


def size(file: IO[bytes]) -> int:
    return len(file.read())


def refuse(why: str) -> None:
    raise Refused(why)


def fail(why: str) -> None:
    raise ValueError(why)


def take_memory() -> int:
    return len(bytearray(2**40 >> 8))


def spin() -> None:
    while True:
        pass


def crash() -> None:
    ctypes.string_at(8)


def end() -> None:
    os._exit(0)


def say(count: int) -> bytes:
    return bytes(count)


def lie() -> object:
    return {"a": [1]}


def forge() -> None:
    """Write an answer of one's own, as a parser could that a file has taken over."""
    for descriptor in range(3, 64):
        try:
            os.write(descriptor, b"\x93" * 5_000)
        except OSError:
            continue
    os._exit(0)


def attempts(room: Path, outside: str) -> list[str]:
    """Return what works of what is forbidden."""
    done = []

    def tried(name: str, attempt: object) -> None:
        try:
            attempt()  # type: ignore[operator]
        except (OSError, ImportError):
            return
        done.append(name)

    tried("own folder", lambda: (room / "x").write_bytes(b"x"))
    tried("read", lambda: Path(outside).read_bytes())
    tried("passwd", lambda: Path("/etc/passwd").read_bytes())
    tried("parent's memory", lambda: Path(f"/proc/{os.getppid()}/environ").read_bytes())
    tried("write", lambda: Path(outside).write_bytes(b"x"))
    tried("write beside", lambda: Path("../evil").write_bytes(b"x"))
    tried("tmp", lambda: Path("/tmp/evil").write_bytes(b"x"))
    tried("socket", lambda: socket.socket(socket.AF_INET))
    tried("unix socket", lambda: socket.socket(socket.AF_UNIX))
    tried("program", lambda: subprocess.run(["/bin/true"], check=True))
    tried("fork", lambda: os.fork() or os._exit(0))
    tried("kill", lambda: os.kill(os.getppid(), 0))
    tried("large file", lambda: (room / "y").write_bytes(bytes(2**20)))
    return done
