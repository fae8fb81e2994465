"""Start programs: a shell, a program in memory, one of its own, and one through the loader.

gains: nothing
score: 20
outcome: completed
"""

import os
import shutil
import subprocess

from kit import attempt, drive, gained, libc, syscall

with attempt():
    gained(f"starts programs: {subprocess.check_output(['/bin/echo', 'yes'], timeout=5)}")
with attempt():
    if os.system("true") == 0:
        gained("starts programs: a shell")
with attempt():
    shutil.copyfile("/bin/true", "own")
    os.chmod("own", 0o755)
    if libc.execve(b"own", None, None) == 0:
        gained("unreachable")
fd = syscall(319, b"program", 0)
if fd >= 0:
    gained("uses calls of the kernel that no node needs: memfd_create")
with attempt():
    os.access("/bin/true", os.X_OK)
    child = os.posix_spawn("/bin/true", ["true"], {})
    os.waitpid(child, 0)
    gained("starts programs: spawned")
drive()
