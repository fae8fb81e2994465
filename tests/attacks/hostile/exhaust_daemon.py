"""Leave a process behind that outlives the trial, in a session of its own.

gains: nothing
score: 20
outcome: completed
"""

import os
import signal

from kit import attempt, drive, gained, libc

with attempt():
    pid = os.fork()
    if not pid:
        os.setsid()
        if os.fork():
            os._exit(0)
        signal.signal(signal.SIGTERM, signal.SIG_IGN)
        os.write(1, f"LEFT {os.getpid()}\n".encode())
        os.closerange(0, 64)
        libc.sleep(30)
        os._exit(0)
    gained("starts processes: a daemon")
with attempt():
    os.posix_spawn("/bin/sleep", ["sleep", "30"], {})
    gained("starts programs: spawned")
drive()
