"""Stop, so that nobody can tell whether it lives, and be continued by nobody.

gains: nothing
score: 0
outcome: hung, died
"""

import os
import signal

from kit import drive

drive(lambda node, scan: os.kill(os.getpid(), signal.SIGSTOP))
