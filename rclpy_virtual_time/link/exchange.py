"""The outcome of a question to a host: the answer and its cost, or why there is no answer."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

import msgspec

UNEXPLAINED = 0.02  # [s] of an exchange without CPU time: something was waited for
STARVED = 4  # times its limit a host may take that the machine does not let run
MAX_REASON = 300  # [characters] of why a frame was refused: it may quote the frame

Answer = TypeVar("Answer")


class HostDied(Exception):
    """The process ended without saying so (`os._exit`, a crash of native code, killed)."""


class HostHung(Exception):
    """The host did not answer within its wall time; `stacks` says where it was."""

    def __init__(self, stacks: str) -> None:
        super().__init__("no answer")
        self.stacks = stacks


class HostForged(Exception):
    """The host sent a frame that no node can send."""


class Flood(Exception):
    """The host said more than it may."""


@dataclass(frozen=True)
class Cost:
    """What one exchange cost the host."""

    wall: float  # [s]
    cpu: float  # [s]; nan where the system doesn't tell
    queued: float = 0.0  # [s] waited for a CPU, by host or judge; measured only if wall >> cpu

    @classmethod
    def uncounted(cls, wall: float, cpu: float) -> Cost:
        """Return the cost where nothing counts waits for a CPU: any wait may have been one."""
        return cls(wall, cpu, wall if math.isnan(cpu) else max(0.0, wall - cpu))

    @property
    def waited(self) -> float:
        """[s] that the host may have waited for a CPU."""
        idle = self.wall - self.cpu
        return max(0.0, idle) if idle <= UNEXPLAINED else self.queued


def status_text(status: str) -> str:
    """Put an exit status into words ("-9": killed by signal 9)."""
    if status.startswith("-"):
        return f"signal {status[1:]}"
    return f"exit code {status or 'unknown'}"


def decoded(body: bytes, decode: Callable[[bytes], Answer]) -> Answer:
    """Decode a frame of a host; HostForged if it isn't one."""
    try:
        return decode(body)
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
        raise HostForged(str(error)[:MAX_REASON]) from None
