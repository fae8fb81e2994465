"""Clone by its number, with every combination of flags that makes a process.

gains: nothing
score: 20
outcome: completed
"""

import os

from kit import drive, gained, syscall

for flags in (17, 0x100 | 17, 0x4000 | 0x100 | 17, 0x8000 | 17, 0x1000 | 17, 0x10000000 | 17):
    pid = syscall(56, flags, None, None, None, None)
    if pid == 0:
        os._exit(0)
    if pid > 0:
        gained(f"starts processes: clone with {flags:#x}")
drive()
