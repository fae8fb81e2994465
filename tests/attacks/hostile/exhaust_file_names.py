"""Make 6,000 files with names of 250 characters, none with anything in it.

gains: nothing
score: 20
outcome: completed, flooded
"""

import os

from kit import attempt, drive

with attempt():
    for number in range(6_000):
        os.close(os.open(f"{number:0250}", os.O_WRONLY | os.O_CREAT))
drive()
