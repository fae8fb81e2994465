"""Start 400 threads, each of which sleeps for ever.

gains: nothing
score: 20
outcome: any
"""

import threading
import time

from kit import attempt, drive

with attempt():
    for _ in range(400):
        threading.Thread(target=time.sleep, args=(1e9,), daemon=True).start()
drive()
