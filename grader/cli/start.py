"""Start the process that will run the node first: it warms up while the judge is imported."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from grader.link.hosts import ForkServer


def start_forkserver(libraries: tuple[str, ...] = ()) -> ForkServer:
    """Start a fork server whose hosts have these modules imported."""
    from grader.link.hosts import ForkServer  # noqa: PLC0415
    from sim.messages import EPOCH_NS  # noqa: PLC0415

    return ForkServer(EPOCH_NS, libraries=libraries)
