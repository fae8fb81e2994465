"""Change what a list of rules for reading and writing forgets: owners, modes, times, attributes.

gains: nothing
score: 20
outcome: completed
"""

import os
import stat

from kit import TARGETS, attempt, drive, gained

for path in TARGETS.get("files", ()):
    for change in (
        lambda file: os.chmod(file, 0o666),
        lambda file: os.utime(file, (1, 1)),
        lambda file: os.chown(file, os.getuid(), os.getgid()),
        lambda file: os.setxattr(file, "user.mark", b"x"),
        lambda file: os.truncate(file, 0),
        lambda file: os.rename(file, file + "~"),
        os.unlink,
    ):
        with attempt():
            before = os.stat(path)
            change(path)
            after = os.stat(path) if os.path.exists(path) else None
            if after is None or (before.st_mode, before.st_mtime, before.st_size) != (
                after.st_mode,
                after.st_mtime,
                after.st_size,
            ):
                gained(f"changes files of others: {stat.filemode(before.st_mode)}")
drive()
