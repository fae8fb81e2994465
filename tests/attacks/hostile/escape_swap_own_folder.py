"""Take its own folder away, and leave a link in its place.

gains: nothing
score: 20
outcome: completed, exception
"""

import os
import shutil

from kit import TARGETS, attempt, drive, gained

own = os.getcwd()
for take_away in (os.rmdir, shutil.rmtree, lambda path: os.rename(path, path + "-gone")):
    with attempt():
        take_away(own)
    with attempt():
        os.symlink(TARGETS["folders"][0], own)
        gained("writes where it may not: beside its own folder")
drive()
