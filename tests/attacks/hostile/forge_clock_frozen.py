"""Freeze virtual time while it works, as if whatever it waits for took no time.

gains: nothing
score: 20
outcome: any
"""

import time

from kit import attempt, drive

from grader.host.virtual import threads


def turn(node, scan):
    kernel = threads.Lock.kernel
    now, until, moved = kernel.now, kernel.world.until, kernel.world.moved
    with attempt():
        kernel.world.until, kernel.world.moved = 2**61, lambda: None
        time.sleep(0.05)
    kernel.now, kernel.world.until, kernel.world.moved = now, until, moved


drive(turn)
