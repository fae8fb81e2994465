"""Trace the fork server, the judge and a bystander, and read and write their memory by other calls.

gains: nothing
score: 20
outcome: completed
"""

import ctypes
import os

from kit import TARGETS, drive, gained, libc, syscall

PTRACE_SEIZE, PTRACE_DETACH = 0x4206, 17


class Piece(ctypes.Structure):
    """A piece of memory."""

    _fields_ = (("base", ctypes.c_void_p), ("size", ctypes.c_size_t))


for pid in (os.getppid(), TARGETS.get("judge", 0), TARGETS.get("bystander", 0)):
    if pid <= 1:
        continue
    if libc.ptrace(PTRACE_SEIZE, pid, None, None) == 0:
        libc.ptrace(PTRACE_DETACH, pid, None, None)
        gained("traces other processes")
    own = ctypes.create_string_buffer(8)
    here = Piece(ctypes.addressof(own), 8)
    there = Piece(0x400000, 8)
    one = ctypes.c_ulong(1)
    if syscall(310, pid, ctypes.byref(here), one, ctypes.byref(there), one, 0) > 0:
        gained("opens the memory of other processes")
    pidfd = syscall(434, pid, 0)
    if pidfd >= 0:
        gained("uses calls of the kernel that no node needs: pidfd_open")
        if syscall(438, pidfd, 1, 0) >= 0:
            gained("takes a descriptor from a process")
drive()
