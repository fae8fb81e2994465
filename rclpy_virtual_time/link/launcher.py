"""A launcher starts hosts: with Linux's means, or without.

`hosts` has Linux's: a fork server and layers of isolation. `practice` needs nothing but Python.
"""

from __future__ import annotations

from contextlib import AbstractContextManager
from pathlib import Path
from typing import Protocol

from rclpy_virtual_time.link.link import Link
from rclpy_virtual_time.link.workplace import Workplace

NEEDS_FILES = "Landlock: Linux 5.13 or later, built and started with it"
FOREIGN_CODE = (
    "nothing keeps a submission from reading solutions, secrets and other submissions "
    f"(needed: {NEEDS_FILES}); use a throw-away machine, and say so with --trust"
)


class Launcher(Protocol):
    """Starts hosts."""

    @property
    def isolation(self) -> str:
        """What stands between students' code and this machine."""

    @property
    def practice(self) -> str:
        """Why a grading by this launcher is for practice only; "" if it counts."""

    @property
    def foreign_code(self) -> str:
        """Why other people's code should not run here; "" if it may."""

    @property
    def guards_files(self) -> bool:
        """Whether something keeps hosts from changing other files of this user's."""

    @property
    def workshop(self) -> Launcher:
        """The launcher of hosts for scripts that goes with this one."""

    def workplace(self, folder: Path) -> AbstractContextManager[Workplace]:
        """Prepare a folder for several hosts, one after another."""

    def host(self, place: Path | Workplace) -> AbstractContextManager[Link]:
        """Start a host that works in a folder; it is dead when the block ends."""
