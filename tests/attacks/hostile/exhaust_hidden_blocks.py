"""Reserve blocks past the end of one small file, where its size does not show them.

gains: nothing
score: 20
outcome: completed, flooded
"""

import os

from kit import attempt, drive, gained, syscall

size = 0
with attempt():
    fd = os.open("small", os.O_RDWR | os.O_CREAT)
    for number in range(20):
        if syscall(285, fd, 1, number * (60 << 20), 60 << 20) == 0:
            size += 60
if size > 256:
    gained("takes more disk than 256 MiB")
drive()
