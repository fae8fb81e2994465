"""What unpickling a large model does, told at its start: it takes longer than any test waits.

It sleeps in small pieces, because a signal that comes just before a sleep does not cut it short.
"""

import time

print("loading")
for _ in range(60):
    time.sleep(1.0)
