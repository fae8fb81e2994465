"""End at once, but refuse to go: endless handlers at exit, a thread that can't be joined.

gains: nothing
score: 0
outcome: hung
"""

import atexit
import threading

from kit import libc


def stay():
    while True:
        libc.sleep(1_000)


atexit.register(stay)
threading.Thread(target=stay, daemon=False).start()
