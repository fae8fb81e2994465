"""The engine's launchers, with the robot's clock and the course's advice."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

from grader.errors import InputError
from rclpy_virtual_time.link import choice
from rclpy_virtual_time.link.errors import NoRos
from rclpy_virtual_time.link.pool import ForkServerPool
from rclpy_virtual_time.link.practice import PracticeServer
from rclpy_virtual_time.link.ros_environment import RosEnvironment
from sim.messages import EPOCH_NS
from sim.sensors import SENSORS

if TYPE_CHECKING:
    from rclpy_virtual_time.link.hosts import ForkServer

ADVICE = "grader.advice:Advisor"
HOSTED = (  # what hosts of nodes need: of the course, whose files they can't read; sensors' types
    "grader.colcon.packages",
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

    Raises
    ------
    InputError
        There is no ROS 2.
    """
    from rclpy_virtual_time.link.hosts import ForkServer  # noqa: PLC0415

    with _asking_for_ros():
        return ForkServer(EPOCH_NS, ros, libraries=(*HOSTED, *libraries), **COURSE, **options)


def start_launcher(
    libraries: tuple[str, ...] = (), *, portable: bool = False
) -> ForkServer | PracticeServer:
    """Start a launcher of hosts that have imported these modules.

    `portable` takes the portable runtime also where the real rclpy is.

    Raises
    ------
    InputError
        There is neither.
    """
    with _asking_for_ros():
        return choice.start_launcher(EPOCH_NS, (*HOSTED, *libraries), portable=portable, **COURSE)


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
    reason = choice.why_not_linux()
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
