"""Say what to do about an exception that comes from where a node runs, not from its own code.

A package of ROS that is not installed, a call that the sandbox refuses, a program that wants to be
typed to: Python's own words for these (`[Errno 1] Operation not permitted`) help nobody.
"""

from __future__ import annotations

import errno
import functools
import os
import re
import socket
import sys
import traceback
from collections.abc import Callable, Iterator
from pathlib import Path, PurePath
from typing import Any

from grader.advice.plain_words import INSTEAD
from rclpy_virtual_time import Advice

DISTRO = os.environ.get("ROS_DISTRO", "jazzy")  # hosts are told

# Modules of ROS 2 that PyPI does not have, and the apt package of each without "ros-jazzy-".
ONLY_APT = {name: name.replace("_", "-") for name in (
    "ackermann_msgs", "camera_info_manager", "control_msgs", "cv_bridge", "diagnostic_updater",
    "example_interfaces", "geographic_msgs", "image_geometry", "image_transport",
    "interactive_markers", "irobot_create_msgs", "joint_state_publisher", "joy", "laser_geometry",
    "launch", "launch_ros", "launch_testing", "map_msgs", "message_filters", "moveit_msgs",
    "nav2_msgs", "nav2_simple_commander", "ros2bag", "rosbag2_py", "rosidl_runtime_py",
    "sensor_msgs_py", "slam_toolbox", "teleop_twist_keyboard", "tf2_geometry_msgs", "tf2_kdl",
    "tf2_msgs", "tf2_py", "tf2_sensor_msgs", "tf_transformations", "turtlebot3_msgs", "turtlesim",
    "vision_msgs",
)} | {"tf2_ros": "tf2-ros-py"}  # fmt: skip

OF_ROS_1 = {
    "rospy": "rclpy, and much has another form: a class that is a Node with create_publisher, "
    "create_subscription and create_timer (for rospy.Rate), and rclpy.spin(node)",
    "catkin_pkg": "a setup.py that calls setup(…, entry_points=…) itself",
    "roslib": "rclpy", "tf": "tf2_ros", "actionlib": "rclpy.action",
    "dynamic_reconfigure": "parameters of the node: declare_parameter",
}  # fmt: skip
INTERFACES = re.compile(r"\w+_(msgs|srvs|interfaces|actions?)")
SOURCES = {  # on GitHub, of those that courses use
    "neato2_interfaces": "comprobo23/neato_packages", "vesc_msgs": "f1tenth/vesc/tree/ros2",
    "nav2_msgs": "ros-navigation/navigation2", "turtlesim": "ros/ros_tutorials/tree/jazzy",
    "irobot_create_msgs": "iRobotEducation/irobot_create_msgs",
}  # fmt: skip

PROCESSES = "a node is one process here and may start no other: let a thread do it, or do without"
NETWORK = "a node has no network here: what it needs has to lie in a file beside it"
FILES = "a node may use the files in its own folder only, besides the libraries that it imports"
SPACE = (
    f"a node's folder holds {Advice.MAX_FOLDER >> 20} MiB in {Advice.MAX_FOLDER_FILES:,} files, "
    "and is full"
)
MEMORY = f"a node may use {Advice.MAX_MEMORY >> 30} GiB of memory here, and this would be more"
THREADS = (
    f"a node may have {Advice.MAX_PROCESSES} threads and {Advice.MAX_MEMORY >> 30} GiB of memory "
    "here, of which each thread takes 8 MiB"
)
OUT_OF_MEMORY = re.compile(r"bad_alloc|can't allocate memory|cannot allocate memory", re.IGNORECASE)
KEYBOARD = (
    "nobody types to a node here: `course drive --keys wwad` does, `--stdin FILE` gives it lines "
    "to read; what is handed in takes a ROS parameter instead"
)
SCREEN = (
    "there is no screen and no keyboard here for curses, keyboard or pynput: `course drive --keys "
    "wwad` types to a node that reads stdin; what is handed in takes a ROS parameter instead"
)
NEEDS = {
    **dict.fromkeys(("getch", "getkey", "readchar", "sshkeyboard"), KEYBOARD),
    **dict.fromkeys(("curses", "keyboard", "pynput"), SCREEN),
}
CONTEXT = (
    "`with rclpy.init():` works from ROS 2 Kilted on; in Jazzy, rclpy.init() returns nothing: call "
    "it alone, and rclpy.shutdown() at the end"
)
ARGUMENTS = (
    "a node has no arguments here but ROS's: take a ROS parameter, which "
    "`course drive --param NAME:=VALUE` sets"
)
PARAMETERS = (
    "there is no such file here: `data_files` in setup.py has to install what a launch file reads; "
    "another machine's folders, and what a link leads to, are not here"
)
OF_LINES = (  # kind of an exception, what it says, what stands in the line: what to do
    (TypeError, "context manager", "rclpy.init(", CONTEXT),
    (IndexError, "", "sys.argv[", ARGUMENTS),
    (RuntimeError, "Error opening YAML file", "", PARAMETERS),
    (
        ImportError,
        "(unknown location)",
        "",
        "a folder without __init__.py is imported as an empty "
        "package: add that file, or import from a module in the folder",
    ),
)
OF_OS = ("<frozen os>", os.__file__)  # where `os.environ[…]` raises
NO_PACKAGE = "PackageNotFoundError"  # of ament_index_python; a KeyError
RELATIVE = (
    "a file that is run itself is in no package, here and with python3: give `course` the folder "
    "with package.xml, or leave the dot out for a file beside it"
)
STARTERS = ("subprocess.py", "popen_fork.py", "popen_spawn_posix.py", "popen_forkserver.py",
            "forkserver.py", "resource_tracker.py", "pty.py")  # fmt: skip
NOT_RUN = 127 << 8  # what os.system returns where no shell could be started
STARTS = re.compile(r"\b(fork|forkpty|posix_spawnp?|spawn[lv]p?e?|exec[lv]p?e?)\s*\(")


def hint(error: BaseException) -> str:
    """Return advice on an exception, in a sentence; "" for an exception of the program's own."""
    if file := Advice.hiding_file(error):
        return _hiding(PurePath(file))
    if isinstance(error, ModuleNotFoundError):
        name = (error.name or "").partition(".")[0]
        return _of_own_package(error, name) or NEEDS.get(name) or missing_package(name)
    if said := _of_a_terminal(error):
        return said
    if isinstance(error, KeyError) and _last_file(error) in OF_OS:
        return (
            "environment variables are not passed on to a node: `course drive --env "
            f"{error.args[0]}=VALUE` sets this one; what is handed in takes a ROS parameter instead"
        )
    for kind, text, code, said in OF_LINES:
        if isinstance(error, kind) and text in str(error) and code in _last_line(error):
            return said
    if type(error).__name__ == NO_PACKAGE:
        return no_package(str(error))
    if isinstance(error, ImportError) and "no known parent package" in str(error):
        return RELATIVE
    for cause in _causes(error):
        if isinstance(cause, RuntimeError) and str(cause) == "can't start new thread":
            return THREADS
        if isinstance(cause, MemoryError) or OUT_OF_MEMORY.search(str(cause)):
            return MEMORY
        if isinstance(cause, OSError) and (said := _refusal(cause)):
            return said
    return ""


def _of_own_package(error: BaseException, name: str) -> str:
    """Name the package of a module that lies beside the file that imports it."""
    for frame in reversed(traceback.extract_tb(error.__traceback__)):
        file = Path(frame.filename)
        if file.with_name(f"{name}.py").is_file():
            package = file.parent.name
            return (
                f"{name}.py lies in the package {package}, and is imported by the package's name: "
                f"`from {package}.{name} import …`"
            )
    return ""


def _hiding(file: PurePath) -> str:
    """Say that a file of the program's has the name of a module that something else needs."""
    package = file.stem == "__init__"
    name = file.parent.name if package else file.stem
    what = f"the folder {name}/" if package else file.name
    return (
        f"`import {name}` finds {what} beside the node, not the module of that name that is "
        "installed: give yours another name"
    )


def missing_package(name: str) -> str:
    """Name the source of a ROS module that is not installed; "" if it isn't of ROS."""
    if name in OF_ROS_1:
        return f"`{name}` belongs to ROS 1; in ROS 2 it is {OF_ROS_1[name]}"
    if name in INSTEAD:
        return ""  # it is said by `plain_words`
    laid = (INTERFACES.fullmatch(name) or name in SOURCES) and name not in sys.modules
    source = f" from github.com/{SOURCES[name]}" if name in SOURCES else ""
    lay = (
        f"lay the folder {name}{source}, with its msg/, srv/ or action/, its package.xml and "
        "CMakeLists.txt (rosidl_generate_interfaces), beside the node"
    )
    if name in ONLY_APT:
        return (
            f"{name} is part of ROS 2, but pip has no package of it: "
            f"{lay if laid else 'do without it'}, or, where ROS 2 is installed on Ubuntu, `sudo "
            f"apt install ros-{DISTRO}-{ONLY_APT[name]}`, then `source "
            f"/opt/ros/{DISTRO}/setup.bash` before `course`"
        )
    return f"{lay}; of a package, beside that, and hand in the folder above both" if laid else ""


def no_package(said: str) -> str:
    """Return advice on a `PackageNotFoundError` with this text."""
    name = re.search(r"'(\w+)'", said)
    return (
        f"there is no package {name[1] if name else 'of that name'} here: only ROS's, and your own "
        "if `course` gets the folder with its package.xml"
    )


def _of_a_terminal(error: BaseException) -> str:
    kind = type(error)
    if kind.__name__ == "error" and kind.__module__ in ("termios", "_curses"):
        return KEYBOARD if kind.__module__ == "termios" else SCREEN
    if isinstance(error, EOFError):
        return KEYBOARD if "reading a line" in str(error) else ""
    frames = traceback.extract_tb(error.__traceback__)
    found = isinstance(error, ImportError) and any("pynput" in each.filename for each in frames)
    return SCREEN if found else ""


def _last_file(error: BaseException) -> str:
    frames = traceback.extract_tb(error.__traceback__)
    return frames[-1].filename if frames else ""


def _last_line(error: BaseException) -> str:
    frames = traceback.extract_tb(error.__traceback__)
    return (frames[-1].line or "") if frames else ""


def _causes(error: BaseException) -> Iterator[BaseException]:
    """Yield the exception and its causes, because libraries wrap the system's errors."""
    seen: set[int] = set()
    cause: BaseException | None = error
    while cause is not None and id(cause) not in seen:
        seen.add(id(cause))
        yield cause
        reason = getattr(cause, "reason", None)  # of urllib's URLError
        inner = reason if isinstance(reason, BaseException) else None
        cause = cause.__cause__ or cause.__context__ or inner


def _refusal(error: OSError) -> str:
    """Name what the sandbox forbids, if the exception comes from the sandbox."""
    if isinstance(error, socket.gaierror):
        return NETWORK
    if error.errno == errno.ENOSPC:
        return SPACE
    if error.errno not in (errno.EPERM, errno.EACCES):
        return ""
    frames = traceback.extract_tb(error.__traceback__)
    files = {PurePath(frame.filename).name for frame in frames}
    if files.intersection(STARTERS) or (frames and STARTS.search(frames[-1].line or "")):
        return PROCESSES
    if "socket.py" in files or (frames and "socket" in (frames[-1].line or "")):
        return NETWORK
    return FILES if error.filename is not None else ""


def tell_of_shell_commands() -> None:
    """Let `os.system` say that it can't do anything: it only returns a number."""
    module: Any = os
    module.system = _telling(os.system)


def _telling(system: Callable[[Any], int]) -> Callable[[Any], int]:
    @functools.wraps(system)
    def run(command: Any) -> int:
        status = system(command)
        if status in (-1, NOT_RUN):
            print(f"os.system({command!r}) returned {status}: {PROCESSES}", file=sys.stderr)
        return status

    run.__module__ = "os"  # where pickle finds it
    return run
