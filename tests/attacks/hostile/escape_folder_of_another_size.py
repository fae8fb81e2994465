"""Make its own folder larger: by remounting, and by limits that it sets itself.

gains: nothing
score: 20
outcome: completed
"""

import os
import resource

from kit import attempt, drive, gained, libc

if libc.mount(b"none", os.getcwd().encode(), None, 32, b"size=8g,nr_inodes=0") == 0:
    gained("mounts a file system: with another size")
for limit in (resource.RLIMIT_FSIZE, resource.RLIMIT_NPROC, resource.RLIMIT_NOFILE):
    with attempt():
        soft, hard = resource.getrlimit(limit)
        resource.setrlimit(limit, (hard + 1, hard + 1))
        gained("changes limits and priorities of other processes: its own hard limit")
drive()
