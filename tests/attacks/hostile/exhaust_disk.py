"""Fill the disk: files of its own, large and many, and /dev/shm (with a fuse: 200 files, 300 MB).

gains: nothing
score: 20
outcome: completed
"""

import os

from kit import TARGETS, attempt, drive, gained

with attempt():
    fd = os.open("large", os.O_WRONLY | os.O_CREAT)
    os.posix_fallocate(fd, 0, 65 * 1024 * 1024)
    gained("writes a file of more than 64 MiB")
with attempt():
    os.unlink("large")
for number in range(200):
    with attempt():
        os.close(os.open(f"many-{number}", os.O_WRONLY | os.O_CREAT))
with attempt():
    size = 0
    for number in range(3):
        fd = os.open(f"/dev/shm/{TARGETS.get('mark', 'x')}-{number}", os.O_RDWR | os.O_CREAT)
        os.posix_fallocate(fd, 0, 60 * 1024 * 1024)
        size += 60
        if size > 64:
            gained("takes more than 64 MiB of shared memory")
drive()
