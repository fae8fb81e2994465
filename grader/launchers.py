"""The engine's launchers, with the robot's clock and the course's advice."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from grader.link import choice
from grader.link.pool import ForkServerPool
from grader.link.practice import PracticeServer
from grader.link.ros_environment import RosEnvironment
from sim.messages import EPOCH_NS

if TYPE_CHECKING:
    from grader.link.hosts import ForkServer

ADVICE = "grader.advice:Advisor"
HOSTED = (  # what hosts of nodes need of the course; they can't read its files
    "grader.colcon.packages",
    "grader.hosted.supplied.classifiers",
    "grader.hosted.supplied.kept",
    "grader.hosted.supplied.probes",
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
    from grader.link.hosts import ForkServer  # noqa: PLC0415

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
    return choice.start_launcher(EPOCH_NS, (*HOSTED, *libraries), portable=portable, **COURSE)


def launcher_pool(most: int | None = None) -> ForkServerPool:
    """Return a pool of launchers, of which at most so many are warm at once."""
    return ForkServerPool(start_launcher, most)
