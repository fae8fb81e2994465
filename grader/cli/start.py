"""Start the process that will run the node first: it warms up while the judge is imported."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from rclpy_virtual_time import ForkServer, PracticeServer

portable_option = click.option(
    "--portable", is_flag=True, help="Practice without ROS and without isolation, as on any system."
)


def start_forkserver(
    libraries: tuple[str, ...] = (), *, portable: bool = False
) -> ForkServer | PracticeServer:
    """Start what starts hosts that have these modules imported."""
    from grader.launchers import start_launcher  # noqa: PLC0415

    return start_launcher(libraries, portable=portable)
