"""Take all memory there is (with a fuse: 6.4 GB, of which no page is touched).

gains: nothing
score: 0
outcome: exception
"""

import mmap

from kit import gained

kept = [mmap.mmap(-1, 64 * 1024 * 1024) for _ in range(100)]
gained("maps 6.4 GB")
