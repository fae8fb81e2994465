"""Build a folder in a folder in a folder, so that whoever tidies up sinks in it.

gains: nothing
score: 20
outcome: completed, flooded
"""

import os

from kit import attempt, drive

home = os.getcwd()
with attempt():
    for _ in range(3_000):
        os.mkdir("d")
        os.chdir("d")
os.chdir(home)
for name in ("\n", "\x1b[2J", "a" * 255, os.fsdecode(b"\xff\xfe")):
    with attempt():
        os.mkdir(name, 0o000)
drive()
