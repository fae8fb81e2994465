"""Fill the folder to its last byte before the host's own code writes there.

gains: nothing
score: 20
outcome: completed, flooded, exception
"""

import os

from kit import attempt, drive

for number in range(40):
    with attempt():
        fd = os.open(f"full-{number}", os.O_WRONLY | os.O_CREAT)
        while os.write(fd, bytes(1 << 20)):
            pass
drive()
