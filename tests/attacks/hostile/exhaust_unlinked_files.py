"""Hold files that have no name, where nobody who lists the folder sees them.

gains: nothing
score: 20
outcome: completed, flooded
"""

import os

from kit import attempt, drive, gained

size = 0
with attempt():
    for _ in range(20):
        fd = os.open("large", os.O_WRONLY | os.O_CREAT)
        os.unlink("large")
        os.posix_fallocate(fd, 0, 60 << 20)
        size += 60
if size > 900:
    gained("takes more disk than 256 MiB")
drive()
