"""A loop that swallows every exception, ignores every signal, and ends never.

gains: nothing
score: 0
outcome: hung
"""

import signal

from kit import attempt, drive


def loop(node, scan):
    for number in range(1, 65):
        with attempt():
            signal.signal(number, signal.SIG_IGN)
    signal.pthread_sigmask(signal.SIG_BLOCK, range(1, 65))
    while True:
        try:
            while True:
                pass
        except BaseException:
            continue


drive(loop)
