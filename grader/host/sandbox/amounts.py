"""How much of the machine a host may take; what enforces it is in the other modules."""

from __future__ import annotations

MAX_FILE = 64 * 1024 * 1024  # [bytes] of one file
MAX_PROCESSES = 512  # threads count too; of the unprivileged user as a whole
MAX_FOLDER = 256 * 1024 * 1024  # [bytes] of a node's folder
MAX_FILES = 5_000  # in it
