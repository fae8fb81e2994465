"""Let the kernel copy others' files: sendfile, splice, copy_file_range, mmap.

gains: nothing
score: 20
outcome: completed
"""

import mmap
import os

from kit import TARGETS, attempt, drive, gained

for number, path in enumerate(TARGETS.get("files", ())):
    with attempt():
        source = os.open(path, os.O_PATH)
        target = os.open(f"copy-{number}", os.O_RDWR | os.O_CREAT)
        for copy in (os.copy_file_range, lambda a, b, n: os.sendfile(b, a, 0, n)):
            with attempt():
                if copy(source, target, 100):
                    gained("reads files that are not its own: copied")
        for door in (f"/proc/self/fd/{source}", f"/dev/fd/{source}"):
            with attempt():
                os.close(os.open(door, os.O_RDONLY))
                gained("reads files that are not its own: opened again")
        with attempt():
            mmap.mmap(source, 1, mmap.MAP_SHARED, mmap.PROT_READ)
            gained("reads files that are not its own: mapped")
drive()
