"""The engine's launchers, with the robot's clock and the course's advice."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

from grader.errors import InputError
from rclpy_virtual_time import NoRos, PracticeServer, RosEnvironment
from rclpy_virtual_time import start_launcher as start_engine
from sim.messages import EPOCH_NS
from sim.sensors import SENSORS

if TYPE_CHECKING:
    from rclpy_virtual_time import ForkServer

ADVICE = "grader.advice.advisor:Advisor"
HOSTED = (  # what hosts of nodes need: of the course, whose files they can't read; sensors' types
    "grader.colcon.packages",
    "grader.hosted.program",
    "grader.hosted.supplied.classifiers",
    "grader.hosted.supplied.kept",
    "grader.hosted.supplied.probes",
    *(sensor.type for sensor in SENSORS),
)
COURSE: dict[str, Any] = {
    "advice": ADVICE,
    "workshop": (
        "numpy", "sklearn.ensemble", "skl2onnx", "onnxruntime", "grader.hosted.models"
    ),
}  # fmt: skip


def fork_server(
    ros: RosEnvironment | None = None, *, libraries: Sequence[str] = (), **options: Any
) -> ForkServer:
    """Start a fork server for nodes; `options` are those of `ForkServer`.

    Raises InputError: there is no ROS 2.
    """
    from rclpy_virtual_time import ForkServer  # noqa: PLC0415

    with _asking_for_ros():
        return ForkServer(EPOCH_NS, ros, libraries=(*HOSTED, *libraries), **COURSE, **options)


def start_launcher(
    libraries: tuple[str, ...] = (), *, portable: bool = False
) -> ForkServer | PracticeServer:
    """Start a launcher of hosts that have imported these modules.

    `portable` takes the portable runtime also where the real rclpy is.

    Raises InputError: there is neither.
    """
    with _asking_for_ros():
        return start_engine(EPOCH_NS, (*HOSTED, *libraries), portable=portable, **COURSE)


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
        self,
        start: Callable[[tuple[str, ...]], ForkServer | PracticeServer],
        most: int | None = None,
    ) -> None:
        self._start = start
        self._most = most
        self._warm: dict[
            tuple[str, ...], ForkServer | PracticeServer
        ] = {}  # the one used last is the last

    def __enter__(self) -> ForkServerPool:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def of(self, libraries: tuple[str, ...] = ()) -> ForkServer | PracticeServer:
        """Return a launcher that has imported these modules: a fork server, where there can be one.

        Raises EngineError: it can't be started.
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


def launcher_pool(most: int | None = None) -> ForkServerPool:
    """Return a pool of launchers, of which at most so many are warm at once."""
    return ForkServerPool(start_launcher, most)


@contextlib.contextmanager
def _asking_for_ros() -> Iterator[None]:
    try:
        yield
    except NoRos as error:
        raise InputError(str(error)) from error


def why_no_class(*, trust: bool) -> str:
    """Say why a class can't be graded on this machine; "" if it can, or if `trust` lets it."""
    reason = PracticeServer.why_needed()
    if not reason:
        return ""
    if not hasattr(os, "fork") or not os.path.isdir("/proc"):  # noqa: PTH112
        return f"course autograde needs Linux: {reason}"
    if trust:
        return ""
    return (
        f"submissions would be graded for practice only, and without isolation: {reason} "
        "(--trust does it all the same)"
    )
