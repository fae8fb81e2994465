"""Signal the fork server, the judge and a bystander (with signal 0, and one that does no harm).

gains: nothing
score: 20
outcome: completed
"""

import fcntl
import os
import signal

from kit import TARGETS, attempt, drive, gained, syscall

own = os.getpid()
for pid in (os.getppid(), TARGETS.get("judge", 0), TARGETS.get("bystander", 0)):
    if pid <= 1:
        continue
    with attempt():
        os.kill(pid, 0)
        gained("signals other processes: kill")
    if syscall(234, pid, pid, 0) == 0:
        gained("signals other processes: tgkill")
    if syscall(200, pid, 0) == 0:
        gained("signals other processes: tkill")
    with attempt():
        ours, theirs = os.pipe()
        fcntl.fcntl(ours, fcntl.F_SETSIG, signal.SIGCONT)
        fcntl.fcntl(ours, fcntl.F_SETOWN, pid)
        fcntl.fcntl(ours, fcntl.F_SETFL, os.O_ASYNC | os.O_NONBLOCK)
        os.write(theirs, b"x")
victim = TARGETS.get("listener", 0)
if victim > 1:  # a process that notes SIGCONT: only it knows whether the signal came
    with attempt():
        ours, theirs = os.pipe()
        fcntl.fcntl(ours, fcntl.F_SETSIG, signal.SIGUSR2)
        fcntl.fcntl(ours, fcntl.F_SETOWN, victim)
        fcntl.fcntl(ours, fcntl.F_SETFL, os.O_ASYNC | os.O_NONBLOCK)
        os.write(theirs, b"x")
drive()
