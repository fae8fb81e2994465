"""Machines that offer less: a judge that is an ordinary user, and no user namespaces."""

import ctypes
import json
import os
import struct
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from rclpy_virtual_time.host.sandbox import kernel_filters, layers, users

ROOT = Path(__file__).resolve().parents[2]
NOBODY = 65534
OUT_OF_REACH = "the interpreter is out of reach for another user"
BOOT = """
import sys
sys.path[:0] = {paths!r}
from rclpy_virtual_time.tests import ordinary
ordinary.become_ordinary()
if not {namespaces}:
    ordinary.refuse_namespaces()
"""


def run_as_ordinary(script: str, *, namespaces: bool = True) -> subprocess.Popen[str]:
    """Start a script as an ordinary user, who may make user namespaces or not."""
    paths = [str(ROOT), *(path for path in sys.path if Path(path).is_relative_to(ROOT))]
    boot = BOOT.format(paths=paths, namespaces=namespaces)
    return subprocess.Popen(
        [sys.executable, "-B", "-c", boot + script],
        stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        cwd="/", env={"PATH": "/usr/bin:/bin", "TMPDIR": "/tmp", "HOME": "/tmp"},
    )  # fmt: skip


def said_by_ordinary(script: str, *, namespaces: bool = True) -> Any:
    """Return what the last line says, as JSON, that a script prints as an ordinary user.

    A text says why it can't be tried here: the test is skipped.
    """
    with run_as_ordinary(script, namespaces=namespaces) as judge:
        said, complaints = judge.communicate(timeout=120)
    if OUT_OF_REACH in complaints:
        pytest.skip(OUT_OF_REACH)
    assert judge.returncode == 0, complaints
    answer = json.loads(said.splitlines()[-1])
    if isinstance(answer, str):
        pytest.skip(answer)
    return answer


def become_ordinary() -> None:
    """Become another user than root, for good; no change to who already is one.

    With a /dev/shm of its own: what a killed process leaves there stops no node of other tests.
    """
    if os.getuid() != 0:
        return
    paths = [*layers.needed_paths(), ROOT]
    if not (users.own_mounts() and users.open_to_others(paths)):
        raise SystemExit(OUT_OF_REACH)
    users.mount("tmpfs", "/dev/shm", "tmpfs", 0, "mode=1777")
    os.setgroups([])
    os.setresgid(NOBODY, NOBODY, NOBODY)
    os.setresuid(NOBODY, NOBODY, NOBODY)
    libc = ctypes.CDLL(None)
    libc.prctl(kernel_filters.PR_SET_DUMPABLE, 1, 0, 0, 0)  # as if it had been so from its start


def refuse_namespaces() -> None:
    """Let no process from here on make a user namespace, as AppArmor or Docker do."""
    column = kernel_filters.ARCHITECTURES[os.uname().machine][1]
    unshare = kernel_filters.CALLS["unshare"][column]
    program = (
        (kernel_filters.LOAD, 0, 0, kernel_filters.NUMBER),
        (kernel_filters.JUMP_EQUAL, 0, 3, unshare),
        (kernel_filters.LOAD, 0, 0, kernel_filters.FIRST),
        (kernel_filters.JUMP_SET, 0, 1, users.CLONE_NEWUSER),
        (kernel_filters.RETURN, 0, 0, kernel_filters.REFUSE | 1),
        (kernel_filters.RETURN, 0, 0, kernel_filters.ALLOW),
    )
    code = b"".join(struct.pack("HBBI", *step) for step in program)
    steps = ctypes.create_string_buffer(code, len(code))
    header = struct.pack("HxxxxxxQ", len(program), ctypes.addressof(steps))
    filter_ = ctypes.create_string_buffer(header, len(header))
    libc = ctypes.CDLL(None)
    libc.prctl(kernel_filters.PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0)
    address = ctypes.c_void_p(ctypes.addressof(filter_))
    if libc.prctl(kernel_filters.PR_SET_SECCOMP, 2, address, 0, 0):
        raise SystemExit("no seccomp filters")
