"""Nurseries that stay warm from one grading to the next: rclpy is imported once, not each time."""

from __future__ import annotations

from grader.link.hosts import Nursery
from sim.messages import EPOCH_NS


class WarmNurseries:
    """Nurseries by the libraries that they have imported; each starts when first asked for.

    Used by one thread at a time.

    Parameters
    ----------
    most
        How many may be warm at once; the one that has waited longest goes first. None: any number.
    """

    def __init__(self, most: int | None = None) -> None:
        self._most = most
        self._warm: dict[tuple[str, ...], Nursery] = {}  # the one used last is the last

    def __enter__(self) -> WarmNurseries:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def of(self, libraries: tuple[str, ...] = ()) -> Nursery:
        """Return the nursery that has imported these modules.

        Raises
        ------
        GraderError
            It can't be started.
        """
        nursery = self._warm.pop(libraries, None)
        if nursery is None:
            while self._most is not None and len(self._warm) >= self._most:
                self._end(next(iter(self._warm)))
            nursery = Nursery(EPOCH_NS, libraries=libraries)
        self._warm[libraries] = nursery
        return nursery

    def close(self) -> None:
        """End them all: at the end, or after a fault, when nobody knows in what state one is."""
        while self._warm:
            self._end(next(reversed(self._warm)))

    def _end(self, libraries: tuple[str, ...]) -> None:
        self._warm.pop(libraries).__exit__()
