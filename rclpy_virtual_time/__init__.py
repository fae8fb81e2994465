"""Run unchanged rclpy programs in virtual time: isolated, deterministic, recorded at the edge.

The names here are all that others use. Each is imported when it is first asked for, because hosts
need hardly any of them.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .host.advice import Advice
    from .host.desk import ask_judge
    from .host.frames import (
        Delivery,
        Discovery,
        Ended,
        EndpointReport,
        Note,
        Offer,
        ProgramStart,
        Published,
        Question,
        Run,
        Settled,
        Slept,
        Start,
        Told,
    )
    from .link.cell import FileReader
    from .link.choice import start_launcher
    from .link.doctor import Diagnosis
    from .link.errors import DiskFull, EngineError, NoRos
    from .link.exchange import Flood, HostDied, HostForged, HostHung
    from .link.foreign import readable
    from .link.hosts import ForkServer
    from .link.launcher import Launcher
    from .link.link import Link
    from .link.live_hosts import LiveHosts
    from .link.log import LogLine
    from .link.practice import PracticeServer
    from .link.programs import run_programs
    from .link.real_clock import real_clock
    from .link.ros_environment import RosEnvironment
    from .link.scratch import fresh_folder, open_regular_file, sweep
    from .link.workplace import Excess

_ROOMS = {  # and their names
    "host.advice": "Advice",
    "host.desk": "ask_judge",
    "host.frames": (
        "Delivery Discovery Ended EndpointReport Note Offer ProgramStart Published Question "
        "Run Settled Slept Start Told"
    ),
    "link.cell": "FileReader",
    "link.choice": "start_launcher",
    "link.doctor": "Diagnosis",
    "link.errors": "DiskFull EngineError NoRos",
    "link.exchange": "Flood HostDied HostForged HostHung",
    "link.foreign": "readable",
    "link.hosts": "ForkServer",
    "link.launcher": "Launcher",
    "link.link": "Link",
    "link.live_hosts": "LiveHosts",
    "link.log": "LogLine",
    "link.practice": "PracticeServer",
    "link.programs": "run_programs",
    "link.real_clock": "real_clock",
    "link.ros_environment": "RosEnvironment",
    "link.scratch": "fresh_folder open_regular_file sweep",
    "link.workplace": "Excess",
}
_ROOM_OF = {name: room for room, names in _ROOMS.items() for name in names.split()}

__all__ = [
    "Advice",
    "Delivery",
    "Diagnosis",
    "Discovery",
    "DiskFull",
    "Ended",
    "EndpointReport",
    "EngineError",
    "Excess",
    "FileReader",
    "Flood",
    "ForkServer",
    "HostDied",
    "HostForged",
    "HostHung",
    "Launcher",
    "Link",
    "LiveHosts",
    "LogLine",
    "NoRos",
    "Note",
    "Offer",
    "PracticeServer",
    "ProgramStart",
    "Published",
    "Question",
    "RosEnvironment",
    "Run",
    "Settled",
    "Slept",
    "Start",
    "Told",
    "ask_judge",
    "fresh_folder",
    "open_regular_file",
    "readable",
    "real_clock",
    "run_programs",
    "start_launcher",
    "sweep",
]


def __getattr__(name: str) -> Any:
    if name not in _ROOM_OF:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f"{__name__}.{_ROOM_OF[name]}"), name)
