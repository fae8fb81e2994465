"""Open as many files as there can be, and pipes on top.

gains: nothing
score: 20
outcome: any
"""

import os

from kit import attempt, drive, gained

with attempt():
    for _ in range(1_000):
        os.pipe()
    gained("has 2000 descriptors")
os.closerange(20, 300)
drive()
