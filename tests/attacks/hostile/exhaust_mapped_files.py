"""Map files without a name and close them: neither folder nor descriptors show them.

gains: nothing
score: 20
outcome: completed, flooded
"""

import mmap
import os

from kit import attempt, drive, gained

maps, size = [], 0
with attempt():
    for _ in range(20):
        fd = os.open("large", os.O_RDWR | os.O_CREAT)
        os.unlink("large")
        os.posix_fallocate(fd, 0, 60 << 20)
        maps.append(mmap.mmap(fd, 4096))
        os.close(fd)
        size += 60
if size > 900:
    gained("takes more disk than 256 MiB")
drive()
