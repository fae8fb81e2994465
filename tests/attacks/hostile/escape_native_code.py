"""Run machine code of its own: what no filter of Python's can see still has to pass the kernel's.

gains: nothing
score: 20
outcome: completed
"""

import ctypes
import mmap
import platform

from kit import attempt, drive, gained

CODE = bytes.fromhex("b8390000000f05c3")  # mov eax, 57 (fork); syscall; ret
with attempt():
    if platform.machine() == "x86_64":
        page = mmap.mmap(-1, 4096, prot=mmap.PROT_READ | mmap.PROT_WRITE | mmap.PROT_EXEC)
        page.write(CODE)
        start = ctypes.addressof(ctypes.c_char.from_buffer(page))
        said = ctypes.CFUNCTYPE(ctypes.c_long)(start)()
        if said == 0:
            ctypes.CDLL(None)._exit(0)
        if said > 0:
            gained("starts processes: with machine code")
drive()
