"""Say of each start that it slept for 20 s, and go on to be started anew.

gains: nothing
score: 20
outcome: forged, never_spun, completed, returned
"""

import sys
import time

from kit import drive

frame = sys._getframe()
while frame and not hasattr(frame.f_locals.get("session"), "_wire"):
    frame = frame.f_back
session = frame.f_locals["session"]
session.kernel.now = 0
session._starting = True
time.sleep(19.9)
drive()
