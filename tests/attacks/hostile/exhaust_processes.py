"""A fork bomb (with a fuse: 50 processes at most).

gains: nothing
score: 20
outcome: completed
"""

import os

from kit import drive, gained

born = []
for _ in range(50):
    try:
        pid = os.fork()
    except OSError:
        break
    if not pid:
        os.execv("/bin/sleep", ["sleep", "30"])
    born.append(pid)
if born:
    gained("starts processes")
drive()
