"""Publish from a thread that the kernel does not know, all the time.

gains: nothing
score: 20
outcome: any
"""

import ctypes

from kit import drive, libc

running = []


@ctypes.CFUNCTYPE(ctypes.c_void_p, ctypes.c_void_p)
def always(_):
    for _ in range(200):
        for node in running:
            node.drive(0.5)
        libc.usleep(1_000)


def turn(node, scan):
    if not running:
        running.append(node)
        thread = ctypes.c_ulong()
        libc.pthread_create(ctypes.byref(thread), None, always, None)


drive(turn)
