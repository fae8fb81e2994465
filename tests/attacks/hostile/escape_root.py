"""Become somebody else, or root of a world of its own: setuid, unshare, mount, chroot.

gains: nothing
score: 20
outcome: completed
"""

import os

from kit import attempt, drive, gained, libc, syscall

for call in (
    lambda: os.setuid(0),
    lambda: os.setresuid(0, 0, 0),
    lambda: os.setgroups([0]),
    lambda: os.chroot("/tmp"),
    lambda: os.setuid(65534),
):
    with attempt():
        before = os.getresuid(), os.getgroups()
        call()
        if (os.getresuid(), os.getgroups()) != before:
            gained("becomes another user")
for flag, name in ((0x10000000, "user"), (0x00020000, "mount"), (0x40000000, "network")):
    if libc.unshare(flag) == 0:
        gained(f"makes namespaces: {name}")
if libc.mount(b"none", b"/mnt", b"tmpfs", 0, None) == 0:
    libc.umount2(b"/mnt", 2)
    gained("mounts a file system")
for number, name in ((428, "open_tree"), (430, "fsopen")):
    if syscall(number, *((-100, b"/", 1) if name == "open_tree" else (b"tmpfs", 0))) >= 0:
        gained(f"uses calls of the kernel that no node needs: {name}")
drive()
