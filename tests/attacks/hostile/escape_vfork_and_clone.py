"""Make processes by every call that makes them: fork, vfork, clone, clone3, with odd flags.

gains: nothing
score: 20
outcome: completed
"""

import ctypes
import os

from kit import drive, gained, syscall

CLONE_PARENT, CLONE_NEWUSER, SIGCHLD = 0x8000, 0x10000000, 17


def born(pid, how):
    if pid == 0:
        os._exit(0)
    if pid > 0:
        gained(f"starts processes: with {how}")


born(syscall(57), "fork")
born(syscall(56, SIGCHLD, 0, 0, 0, 0), "clone")
born(syscall(56, CLONE_PARENT | SIGCHLD, 0, 0, 0, 0), "clone beside itself")
born(syscall(56, CLONE_NEWUSER | SIGCHLD, 0, 0, 0, 0), "clone as root of its own world")
request = (ctypes.c_uint64 * 8)(0, 0, 0, 0, SIGCHLD, 0, 0, 0)
born(syscall(435, ctypes.byref(request), ctypes.c_size_t(64)), "clone3")
drive()
