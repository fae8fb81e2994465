"""Start 700 threads that Python knows nothing of, each asleep.

gains: nothing
score: 20
outcome: completed, flooded, exception
"""

import ctypes

from kit import drive, libc

attributes = (ctypes.c_char * 64)()
libc.pthread_attr_init(attributes)
libc.pthread_attr_setstacksize(attributes, ctypes.c_size_t(65_536))
sleep, thread = ctypes.cast(libc.sleep, ctypes.c_void_p), ctypes.c_ulong()
for _ in range(700):
    arguments = (ctypes.byref(thread), attributes, sleep, ctypes.c_void_p(1_000))
    if libc.pthread_create(*arguments):
        break
drive()
