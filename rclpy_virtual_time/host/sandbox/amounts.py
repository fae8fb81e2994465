"""How much of the machine a student's process, the host, may use; other modules enforce it."""

from __future__ import annotations

MAX_FILE = 64 * 1024 * 1024  # [bytes] of one file
MAX_OPEN_FILES = 256  # of one process
MAX_MEMORY = 4 * 1024 * 1024 * 1024  # [bytes] that a process may write to and shares with nobody
MAX_ADDRESSES = 256 * 1024**3  # [bytes] mapped: their tables, a 512th, are memory that counts none
MAX_PROCESSES = 512  # threads count too; of the unprivileged user as a whole
MAX_FOLDER = 256 * 1024 * 1024  # [bytes] of a node's folder
MAX_FOLDER_FILES = 5_000
