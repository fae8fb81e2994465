"""Set the machine's clocks, by every call that there is.

gains: nothing
score: 20
outcome: completed
"""

import ctypes

from kit import drive, gained, syscall

spec = (ctypes.c_long * 32)()
for name, number, arguments in (
    ("clock_settime", 227, (0, spec)),
    ("settimeofday", 164, (spec, None)),
    ("adjtimex", 159, (ctypes.byref((ctypes.c_long * 32)(1)),)),
    ("clock_adjtime", 305, (0, ctypes.byref((ctypes.c_long * 32)(1)))),
):
    if syscall(number, *arguments) >= 0:
        gained(f"uses calls of the kernel that no node needs: {name}")
drive()
