"""What killed hosts leave behind in a /dev/shm that they share with the machine.

Fast DDS keeps a file for each port in /dev/shm. A process that is killed while it makes one leaves
it half made, and whoever wants that port next waits for ever, in rclpy.init() or create_node():
other hosts, and every ROS node of this machine. (Boost's managed_open_or_create_impl waits until
the first word of the file says "initialized".)
"""

import contextlib
import os
from collections.abc import Iterator
from pathlib import Path

from rclpy_virtual_time.link.real_clock import real_clock

SHM = Path("/dev/shm")
OURS = ("fastrtps_", "fastdds_")  # of Fast DDS 2 (Jazzy) and 3 (Kilted)
HALF_MADE = (0, 1)  # first word of a file: not begun, begun; 2 means initialized
MAKING = 1.0  # [s] longer than making one takes: it takes a millisecond


def shared_memory_of(pid: int) -> list[Path]:
    """Return the shared memory files of Fast DDS that a process has mapped."""
    files = {Path(name.removesuffix(" (deleted)")) for *_, name in _mapped(pid)}
    return sorted(files | {file.with_name(f"{file.name}_el") for file in files})


def remove_half_made_ports() -> list[Path]:
    """Remove, and return, the half-made ports of Fast DDS whose processes are gone.

    A process that waits for one has it open, too: after `MAKING` the maker is taken for dead.
    """
    suspects = [p for name in OURS for p in SHM.glob(f"{name}port*") if _is_half_made(p)]
    if not suspects:
        return []
    held = set(_held())
    removed = []
    for port in suspects:
        with contextlib.suppress(OSError):  # another user's, or gone
            state = port.stat()
            fresh = abs(real_clock.time_ns() / 1e9 - state.st_mtime) < MAKING
            in_work = fresh and (state.st_dev, state.st_ino) in held
            if not in_work and _is_half_made(port):
                port.unlink()
                removed.append(port)
    return removed


def _is_half_made(port: Path) -> bool:
    if port.name.endswith("_el"):  # a lock: it is always empty
        return False
    try:
        with port.open("rb") as file:
            word = file.read(4)
    except OSError:
        return False
    return int.from_bytes(word, "little") in HALF_MADE


def _held() -> Iterator[tuple[int, int]]:
    """Give the device and inode of each file that some process has mapped or open.

    Not its name: hosts that have a /dev/shm of their own have files of the same names there.
    """
    for process in Path("/proc").iterdir():
        if not process.name.isdigit():
            continue
        for device, inode, _ in _mapped(int(process.name)):
            yield device, inode
        with contextlib.suppress(OSError):  # it has ended, or is another user's
            for descriptor in (process / "fd").iterdir():
                with contextlib.suppress(OSError):
                    file = descriptor.stat()
                    yield file.st_dev, file.st_ino


def _mapped(pid: int) -> Iterator[tuple[int, int, str]]:
    """Give device, inode and name of Fast DDS's shared memory files that a process has mapped."""
    try:
        maps = Path(f"/proc/{pid}/maps").read_text()
    except OSError:  # it has ended, or is another user's
        return
    for line in maps.splitlines():
        if any(f"{SHM}/{name}" in line for name in OURS):
            _, _, _, device, inode, name = line.split(maxsplit=5)
            major, minor = (int(part, 16) for part in device.split(":"))
            yield os.makedev(major, minor), int(inode), name
