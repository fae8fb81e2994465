"""Interrupt the kernel between any two steps, with a real timer that raises.

gains: nothing
score: 20
outcome: any
"""

import ctypes
import signal

from kit import attempt, drive, libc


def interrupt(*_):
    raise KeyboardInterrupt


with attempt():
    signal.signal(signal.SIGALRM, interrupt)
    every = (ctypes.c_long * 4)(0, 300, 0, 300)  # [s, us]: interval, first
    libc.setitimer(0, every, None)
drive()
