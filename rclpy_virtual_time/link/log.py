"""What a node printed and logged."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class LogLine:
    """One line that the node printed or logged."""

    time: int  # [ns] since the start
    level: str  # debug, info, warn, error, fatal, stdout or stderr
    text: str

    @property
    def t(self) -> float:
        """When the line was printed [s]."""
        return self.time / 1e9
