"""Use up what the kernel has little of: shared memory segments, semaphores, queues, keys.

gains: nothing
score: 20
outcome: completed
"""

import ctypes

from kit import drive, gained, libc

IPC_CREAT, RMID = 0o1000, 0
segment = libc.shmget(0x5EED, 4096, IPC_CREAT | 0o600)
if segment >= 0:
    libc.shmctl(segment, RMID, None)
    gained("uses calls of the kernel that no node needs: shmget")
queue = libc.msgget(0x5EED, IPC_CREAT | 0o600)
if queue >= 0:
    libc.msgctl(queue, RMID, None)
    gained("uses calls of the kernel that no node needs: msgget")
semaphores = libc.semget(0x5EED, 1, IPC_CREAT | 0o600)
if semaphores >= 0:
    libc.semctl(semaphores, 0, RMID)
    gained("uses calls of the kernel that no node needs: semget")
if libc.syscall(ctypes.c_long(248), b"user", b"course", b"x", 1, -3) >= 0:
    gained("uses calls of the kernel that no node needs: add_key")
drive()
