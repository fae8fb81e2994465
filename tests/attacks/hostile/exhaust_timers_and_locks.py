"""Take what a user has few of: timers, queued signals, locked memory, file locks.

gains: nothing
score: 20
outcome: completed
"""

import ctypes
import fcntl

from kit import attempt, drive, libc, syscall

for _ in range(5_000):
    timer = ctypes.c_int()
    if syscall(222, 1, None, ctypes.byref(timer)):
        break
libc.mlockall(3)
with attempt(), open("locked", "w") as file:
    for start in range(10_000):
        fcntl.lockf(file, fcntl.LOCK_EX, 1, 2 * start)
drive()
