"""Take the judge's means away: resource limits and priority of other processes of the same user.

gains: nothing
score: 20
outcome: completed
"""

import ctypes
import os

from kit import TARGETS, attempt, drive, gained, libc, syscall

RLIMIT_CORE = 4


class Limit(ctypes.Structure):
    """A soft and a hard limit."""

    _fields_ = (("soft", ctypes.c_uint64), ("hard", ctypes.c_uint64))


for pid in (os.getppid(), TARGETS.get("judge", 0), TARGETS.get("bystander", 0)):
    if pid <= 1:
        continue
    if libc.prlimit(pid, RLIMIT_CORE, ctypes.byref(Limit(0, 0)), None) == 0:
        gained("changes limits and priorities of other processes: limits")
    with attempt():
        before = os.getpriority(os.PRIO_PROCESS, pid)
        os.setpriority(os.PRIO_PROCESS, pid, before + 1)
        if os.getpriority(os.PRIO_PROCESS, pid) != before:
            gained("changes limits and priorities of other processes: priority")
    with attempt():
        os.sched_setscheduler(pid, os.SCHED_BATCH, os.sched_param(0))
        if os.sched_getscheduler(pid) == os.SCHED_BATCH:
            gained("changes limits and priorities of other processes: scheduling")
    if syscall(251, 1, pid, (2 << 13) | 7) == 0 and syscall(252, 1, pid) == (2 << 13) | 7:
        gained("changes limits and priorities of other processes: disk")
drive()
