"""A keyboard: keys come at fixed times, and stdin says that it is a terminal.

What a teleoperation node does with a terminal works: `select` on stdin, reads of one key or of a
line, `tty.setcbreak` and `termios.tcsetattr`. Every key comes at once, as after `setcbreak`.
"""

from __future__ import annotations

import contextlib
import io
import os
import re
import select
import sys
from typing import Any

from .kernel import Kernel

PERIOD = 500_000_000  # [ns] from key to key; the first comes after one
KEY = re.compile(rb"\x1b\[[0-9;]*[A-Za-z~]|[\xc0-\xff][\x80-\xbf]*|.", re.DOTALL)  # ESC [ A is one
STDIN = 0


def install(kernel: Kernel, keys: bytes) -> None:
    """Make this process's stdin a terminal to which these keys come."""
    end, typed = os.pipe()
    os.dup2(end, STDIN)
    os.close(end)
    for count, key in enumerate(KEY.findall(keys), start=1):
        kernel.call_at(count * PERIOD, _typing(typed, key))
    module: Any = sys
    module.stdin = module.__stdin__ = io.TextIOWrapper(
        io.BufferedReader(_Keyboard()), "utf-8", line_buffering=True
    )
    module = os
    isatty = os.isatty
    module.isatty = lambda fd: fd == STDIN or isatty(fd)
    with contextlib.suppress(ImportError):  # Windows
        _install_attributes()


def _typing(end: int, key: bytes) -> Any:
    return lambda: os.write(end, key)


class _Keyboard(io.RawIOBase):
    """A program's stdin: a read parks until there is a key."""

    name = "<stdin>"

    def readable(self) -> bool:
        return True

    def fileno(self) -> int:
        return STDIN

    def isatty(self) -> bool:
        return True

    def readinto(self, buffer: Any) -> int:
        select.select([STDIN], [], [])
        data = os.read(STDIN, len(buffer))
        buffer[: len(data)] = data
        return len(data)


def _install_attributes() -> None:
    """Let termios keep the attributes set for stdin."""
    import termios  # noqa: PLC0415

    module: Any = termios
    control = [b"\0"] * 32
    control[termios.VMIN], control[termios.VINTR] = b"\x01", b"\x03"
    flags = termios.ICANON | termios.ECHO | termios.ISIG | termios.IEXTEN
    speed = termios.B38400
    kept: list[Any] = [
        termios.ICRNL,
        termios.OPOST,
        termios.CS8 | termios.CREAD,
        flags,
        speed,
        speed,
        control,
    ]

    def get(real: Any) -> Any:
        return lambda fd: [*kept[:-1], list(kept[-1])] if _is_stdin(fd) else real(fd)

    def put(real: Any) -> Any:
        def tcsetattr(fd: Any, when: int, attributes: list[Any]) -> None:
            if not _is_stdin(fd):
                real(fd, when, attributes)
            elif len(attributes) != len(kept):
                raise TypeError("tcsetattr, arg 3: must be 7 element list")
            else:
                kept[:] = attributes

        return tcsetattr

    def ignored(real: Any) -> Any:
        return lambda fd, *rest: None if _is_stdin(fd) else real(fd, *rest)

    module.tcgetattr, module.tcsetattr = get(termios.tcgetattr), put(termios.tcsetattr)
    for name in ("tcdrain", "tcflush", "tcflow", "tcsendbreak"):
        setattr(module, name, ignored(getattr(module, name)))
    import tty  # noqa: PLC0415  (it copies what termios has now, unless it was imported before)

    vars(tty).update({name: value for name, value in vars(termios).items() if name in vars(tty)
                      and name.startswith("tc")})  # fmt: skip


def _is_stdin(fd: Any) -> bool:
    return (fd if isinstance(fd, int) else fd.fileno()) == STDIN
