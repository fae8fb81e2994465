"""Look for open folders that somebody left it, and go on from there.

gains: nothing
score: 20
outcome: completed
"""

import os
import stat

from kit import TARGETS, attempt, drive, gained

for fd in range(256):
    with attempt():
        if stat.S_ISDIR(os.fstat(fd).st_mode):
            gained(f"lists folders that are not its own: {os.listdir(fd)[:3]}")
    for path in TARGETS.get("files", ()):
        with attempt():
            os.close(os.open("../../../../.." + path, os.O_RDONLY, dir_fd=fd))
            gained("reads files that are not its own")
drive()
