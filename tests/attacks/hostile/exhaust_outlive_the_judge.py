"""Undo the signal that ends it with its judge, and ignore all others.

gains: nothing
score: 20
outcome: completed
"""

import os
import signal

from kit import attempt, drive, gained, libc

if libc.prctl(1, 0, 0, 0, 0) == 0:
    gained("leaves processes behind: it does not end with its judge")
for number in range(1, 65):
    with attempt():
        signal.signal(number, signal.SIG_IGN)
for call in (os.setsid, lambda: os.setpgid(0, 0), lambda: os.setresuid(*[os.getuid()] * 3)):
    with attempt():
        call()
drive()
