"""Make this process as poor as one on Windows: what only Linux or Unix has is gone, or raises.

So is what came with ROS's wheels: other systems have only what the course's own wheel asks for.

    python elsewhere.py COURSE_ARGUMENT …
    python elsewhere.py pytest PYTEST_ARGUMENT …
    python elsewhere.py prepare

runs the command `course` there, or pytest with the course's fixtures, or a notebook's `prepare`.
The hosts that it starts begin with `impoverish()`, too.
"""

import builtins
import importlib.abc
import importlib.machinery
import os
import re
import select
import selectors
import signal
import socket
import subprocess
import sys
import tempfile  # noqa: F401  (imported before anything is taken away)
import time
from pathlib import Path
from types import SimpleNamespace
from typing import Any

HERE = Path(__file__).resolve()
PRELUDE = f"import sys; sys.path.insert(0, {str(HERE.parent)!r}); import elsewhere; " + (
    "elsewhere.impoverish()"
)
MODULES = {"fcntl", "grp", "pty", "pwd", "resource", "spwd", "syslog", "termios", "tty"}
LINUX_OURS = (
    "rclpy_virtual_time.host.sandbox.kernel_filters", "rclpy_virtual_time.host.sandbox.layers",
    "rclpy_virtual_time.host.sandbox.limits", "rclpy_virtual_time.host.sandbox.users",
    "rclpy_virtual_time.host.sandbox.workplaces",
    "rclpy_virtual_time.link.hosts", "rclpy_virtual_time.link.pipes", "grader.trial.real_",
)  # fmt: skip
ROS_BRINGS = re.compile(r"ros_.*|lark_parser|empy")  # distributions
MODULE_IN_RECORD = re.compile(r"^(?:[^,]*-packages/)?(\w+)(?:/__init__)?\.py,", re.MULTILINE)
OS = (
    "fork", "forkpty", "setsid", "pidfd_open", "chown", "lchown", "fchown",
    "getuid", "geteuid", "getgid", "setuid", "setgid", "setgroups", "killpg", "getpgid", "setpgid",
    "sched_getaffinity", "sched_setaffinity", "statvfs", "fstatvfs", "mkfifo", "wait3", "wait4",
    "getpriority", "setpriority", "nice", "openpty", "memfd_create", "eventfd", "posix_spawn",
    "unshare", "setns", "getloadavg", "fchmod",
)  # fmt: skip
SIGNAL = (
    "SIGUSR1", "SIGUSR2", "SIGKILL", "SIGALRM", "SIGCHLD", "SIGHUP", "SIGSTOP", "SIGURG",
    "setitimer", "getitimer", "alarm", "pause", "ITIMER_REAL", "pidfd_send_signal",
    "pthread_kill", "pthread_sigmask", "sigwait",
)  # fmt: skip
CLOCKS = (
    "clock_gettime",
    "clock_gettime_ns",
    "clock_settime",
    "clock_settime_ns",
    "pthread_getcpuclockid",
)


class OnlyLinux(Exception):
    """Something was used that is not there on other systems."""


class _Missing(importlib.abc.MetaPathFinder):
    """Finds no module that only Unix has, nor ours that need Linux, nor one that ROS brought."""

    def __init__(self) -> None:
        self._of_ros = ros_modules()

    def find_spec(self, name: str, path: Any = None, target: Any = None) -> Any:
        if name in MODULES or name.startswith(LINUX_OURS):
            raise ModuleNotFoundError(f"No module named {name!r} on this system", name=name)
        if path is None and name in self._of_ros:
            folders = [f for f in sys.path if Path(f).resolve() != self._of_ros[name]]
            return importlib.machinery.PathFinder.find_spec(name, folders) or self._refuse(name)
        return None

    @staticmethod
    def _refuse(name: str) -> None:
        raise ModuleNotFoundError(f"No module named {name!r} without ROS's wheels", name=name)


def ros_modules() -> dict[str, Path]:
    """Return the modules that ROS's wheels brought, and the folder in which they are."""
    found = {}
    for folder in {Path(entry).resolve() for entry in sys.path if entry.endswith("-packages")}:
        for about in folder.glob("*.dist-info"):
            if ROS_BRINGS.fullmatch(about.name.partition("-")[0].lower()):
                record = (about / "RECORD").read_text("utf-8")
                found |= dict.fromkeys(MODULE_IN_RECORD.findall(record), folder)
    return found


def impoverish() -> None:
    """Take away what other systems don't have; `subprocess` keeps its own means."""
    subprocess.signal = SimpleNamespace(**vars(signal))  # type: ignore[attr-defined]
    subprocess._USE_POSIX_SPAWN = False  # it asks os for it, from Python 3.13 on
    sys.meta_path.insert(0, _Missing())
    for name in MODULES:
        sys.modules.pop(name, None)
    for module, names in ((os, OS), (signal, SIGNAL), (time, CLOCKS)):
        for name in names:
            if hasattr(module, name):
                delattr(module, name)
    for name in ("poll", "epoll"):
        delattr(select, name)
    for name in ("PollSelector", "EpollSelector"):
        delattr(selectors, name)
    selectors.DefaultSelector = selectors.SelectSelector  # type: ignore[misc]
    for name in ("AF_UNIX", "SOCK_SEQPACKET", "send_fds", "recv_fds", "socketpair"):
        if hasattr(socket, name) and name != "socketpair":
            delattr(socket, name)
    _without_proc()


def _without_proc() -> None:
    real_open, real_stat = builtins.open, os.stat

    def refuse(path: Any) -> None:
        if isinstance(path, str | bytes | os.PathLike):
            text = os.fsdecode(path)
            if text.startswith(("/proc/", "/sys/")) and "cpu" not in text:
                raise OnlyLinux(text)

    def checked_open(path: Any, *args: Any, **kwargs: Any) -> Any:
        refuse(path)
        return real_open(path, *args, **kwargs)

    def checked_stat(path: Any, *args: Any, **kwargs: Any) -> Any:
        if path == "/proc":
            raise FileNotFoundError(path)
        return real_stat(path, *args, **kwargs)

    builtins.open, os.stat = checked_open, checked_stat


if __name__ == "__main__":
    impoverish()
    from rclpy_virtual_time.link import practice

    practice.PRELUDE = PRELUDE
    if sys.argv[1] == "pytest":
        import pytest

        os.environ["PYTEST_DISABLE_PLUGIN_AUTOLOAD"] = "1"  # of others
        ours = ("-p", "rclpy_virtual_time.testing.plugin", "-p", "grader.testing.plugin")
        sys.exit(pytest.main([*sys.argv[2:], *ours]))
    if sys.argv[1] == "prepare":
        import platform

        from grader.notebook.preparation import prepare_kernel
        from rclpy_virtual_time.link import ros_environment

        platform.machine = lambda: "aarch64"
        ros_environment._has_rclpy = lambda _: False
        prepare_kernel()
        sys.exit()
    from grader.cli import main

    main()
