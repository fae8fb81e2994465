"""Empty and read files of others with openat2, whose flags a filter can't see.

gains: nothing
score: 20
outcome: completed
"""

import ctypes
import os

from kit import TARGETS, drive, gained, syscall

for path in TARGETS.get("files", ()):
    for flags in (os.O_RDONLY, os.O_TRUNC, os.O_ACCMODE | os.O_TRUNC, os.O_PATH):
        how = (ctypes.c_uint64 * 3)(flags, 0, 0)
        if syscall(437, -100, path.encode(), how, 24) >= 0:
            gained("uses calls of the kernel that no node needs: openat2")
drive()
