"""Kill the bystander, then everything that can be killed.

gains: nothing
score: 20
outcome: any
"""

import os
import signal

from kit import TARGETS, attempt, drive, gained

with attempt():
    if TARGETS.get("bystander", 0) > 1:
        os.kill(TARGETS["bystander"], signal.SIGKILL)
        gained("signals other processes: SIGKILL")
if TARGETS.get("all"):  # only where the layers are on: this machine is not ours alone
    for everything in (-1, 0, -os.getppid()):
        with attempt():
            os.kill(everything, signal.SIGKILL)
            gained("signals other processes: all")
drive()
