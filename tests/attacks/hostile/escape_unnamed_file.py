"""Make a file without a name, and give it one where others look.

gains: nothing
score: 20
outcome: completed
"""

import os

from kit import TARGETS, attempt, drive

mark = TARGETS.get("mark", "x")
fd = -1
with attempt():
    fd = os.open(".", os.O_TMPFILE | os.O_RDWR, 0o666)
for folder in ("/tmp", "/var/tmp", "..", "/dev", TARGETS.get("watched", "/root")):
    with attempt():
        os.link(f"/proc/self/fd/{fd}", f"{folder}/{mark}-unnamed", follow_symlinks=True)
    with attempt():
        os.mkdir(f"{folder}/{mark}-folder")
    with attempt():
        os.mkfifo(f"{folder}/{mark}-fifo")
drive()
