"""Look for the folders of other students' trials that run at the same time.

gains: nothing
score: 20
outcome: completed
"""

import glob
import os
import tempfile

from kit import attempt, drive, gained, steal

own = os.getcwd()
for place in ("/tmp", "/var/tmp", "/dev/shm", tempfile.gettempdir(), os.path.dirname(own)):
    with attempt():
        for name in os.listdir(place):
            found = os.path.join(place, name)
            if found != own and "course-" in name and os.path.isdir(found):
                for file in glob.glob(f"{found}/*.py"):
                    steal(file)
                gained("lists folders that are not its own: of another trial")
drive()
