"""Make 100 pipes, as large as they get: memory of the kernel, counted by user.

gains: nothing
score: 20
outcome: completed
"""

import fcntl
import os

from kit import attempt, drive

held = []
for _ in range(100):
    with attempt():
        held += os.pipe()
        fcntl.fcntl(held[-1], 1031, 1 << 20)
        os.set_blocking(held[-1], False)
        os.write(held[-1], bytes(1 << 20))
drive()
