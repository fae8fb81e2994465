"""What judge and host say to each other of colcon packages."""

from __future__ import annotations

from typing import Annotated

import msgspec

from grader.hosted.fields import Name, Text

READ = "grader.colcon.packages:carry_out"  # the task


class ReadPackage(msgspec.Struct, frozen=True):
    """Read the colcon packages in these folders, and the launch file that is named."""

    launch: str = ""
    folders: tuple[str, ...] = ("",)  # below the working folder


class Executable(msgspec.Struct, array_like=True, frozen=True):
    """What `ros2 run` can start of a package."""

    name: Name
    file: Name  # below the folder in which the package is installed
    entry: Annotated[str, msgspec.Meta(pattern=r"^([\w.]{1,120}:[\w.]{1,120})?$")]
    package: Name = ""


Made = dict[Annotated[str, msgspec.Meta(pattern=r"^launch_params_\d{1,3}\.yaml$")], Text]


class Launched(msgspec.Struct, array_like=True, frozen=True):
    """A node of a launch file."""

    executable: Name
    arguments: Annotated[tuple[Text, ...], msgspec.Meta(max_length=200)]
    package: Name = ""
    needed: bool = False  # where it ends, all do
    made: Made = {}  # parameter files


class PackageRead(msgspec.Struct, frozen=True):
    """What a package installs and can start."""

    problem: Text = ""  # why it can't be built
    files: Annotated[dict[Name, Name], msgspec.Meta(max_length=2_000)] = {}  # place: source
    executables: Annotated[tuple[Executable, ...], msgspec.Meta(max_length=100)] = ()
    launched: Annotated[tuple[Launched, ...], msgspec.Meta(max_length=8)] = ()
    unstarted: Text = ""  # why its launch file can't be launched ...
    held: bool = False  # ... here: a person has to look
    notes: Annotated[tuple[Text, ...], msgspec.Meta(max_length=20)] = ()  # what is not started
