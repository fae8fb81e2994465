"""Fork servers kept warm from one grading to the next: rclpy is imported once, not each time."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rclpy_virtual_time.link.hosts import ForkServer
    from rclpy_virtual_time.link.practice import PracticeServer

    AnyServer = ForkServer | PracticeServer


class ForkServerPool:
    """Fork servers by the libraries that they have imported; each starts when first asked for.

    Used by one thread at a time.

    Parameters
    ----------
    start
        Starts one that has imported these modules.
    most
        How many may be warm at once; the one that has waited longest goes first. None: any number.
    """

    def __init__(
        self, start: Callable[[tuple[str, ...]], AnyServer], most: int | None = None
    ) -> None:
        self._start = start
        self._most = most
        self._warm: dict[tuple[str, ...], AnyServer] = {}  # the one used last is the last

    def __enter__(self) -> ForkServerPool:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def of(self, libraries: tuple[str, ...] = ()) -> AnyServer:
        """Return a launcher that has imported these modules: a fork server, where there can be one.

        Raises
        ------
        EngineError
            It can't be started.
        """
        forkserver = self._warm.pop(libraries, None)
        if forkserver is None:
            while self._most is not None and len(self._warm) >= self._most:
                self._end(next(iter(self._warm)))
            forkserver = self._start(libraries)
        self._warm[libraries] = forkserver
        return forkserver

    def close(self) -> None:
        """End all launchers: at the end, or after a fault that leaves their state unknown."""
        while self._warm:
            self._end(next(reversed(self._warm)))

    def _end(self, libraries: tuple[str, ...]) -> None:
        self._warm.pop(libraries).__exit__()
