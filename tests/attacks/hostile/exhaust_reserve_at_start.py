"""Reserve the disk before the judge first looks at the folder (a fuse: 20 files of 60 MiB).

gains: nothing
score: 20
outcome: completed, flooded
"""

import os

from kit import attempt, drive, gained

size = 0
with attempt():
    for number in range(20):
        fd = os.open(f"large-{number}", os.O_WRONLY | os.O_CREAT)
        os.posix_fallocate(fd, 0, 60 << 20)
        size += 60
if size > 900:
    gained("takes more disk than 256 MiB")
drive()
