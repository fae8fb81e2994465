"""Empty files of others by opening them to read, or with the access mode 3 for neither.

gains: nothing
score: 20
outcome: completed
"""

import os

from kit import TARGETS, attempt, drive

for path in TARGETS.get("files", ()):
    for mode in (os.O_RDONLY, os.O_ACCMODE, os.O_WRONLY, os.O_RDWR):
        with attempt():
            os.close(os.open(path, mode | os.O_TRUNC))
drive()
