"""What there is little of: processes, memory, disk, threads, output, messages, patience."""

import atexit
import ctypes
import fcntl
import mmap
import os
import signal
import sys
import threading
import time

from kit import TARGETS, attempt, gained, libc, syscall, trick
from std_msgs.msg import Bool, String

from grader.hosted.questions import MAX_ROWS, Question, ask

HELD = []  # what would be given back if nobody held it


def write_only(name):
    """Open a file of its own."""
    return os.open(name, os.O_WRONLY | os.O_CREAT)


@trick("hung", score=0)
def at_exit():
    """End at once, but refuse to go: endless handlers at exit, a thread that can't be joined."""

    def stay():
        while True:
            libc.sleep(1_000)

    atexit.register(stay)
    threading.Thread(target=stay, daemon=False).start()
    sys.exit()


@trick("hung", score=0)
def deaf_loop(node, scan):
    """Loop without end, swallow every exception, ignore every signal."""
    for number in range(1, 65):
        with attempt():
            signal.signal(number, signal.SIG_IGN)
    signal.pthread_sigmask(signal.SIG_BLOCK, range(1, 65))
    while True:
        try:
            while True:
                pass
        except BaseException:
            continue


@trick("hung", "completed", score=0)
def sleep_for_ever(node, scan):
    """Sleep for ever in native code."""
    while True:
        libc.sleep(1_000)


@trick("any", full=True)
def slow_drip(node, scan):
    """Stay just below the limit of each exchange (with a fuse: three times)."""
    if node.heard <= 3:
        libc.usleep(900_000)


@trick("hung", score=0)
def questions_at_start():
    """Ask the judge's models again and again in the start-up, and wait before each question."""
    for _ in range(1_000):
        with attempt():
            ask(Question("load", "model.pkl"))
        libc.usleep(900_000)


@trick("flooded", score=0)
def rows_for_models(node, scan):
    """Ask a model for everything that it could say: checks have to look at each answer."""
    for _ in range(60):
        ask(Question("predict", "model.pkl", 1, MAX_ROWS, bytes(40 * MAX_ROWS)))


@trick()
def daemon():
    """Leave a process behind that outlives the trial, in a session of its own."""
    with attempt():
        pid = os.fork()
        if not pid:
            os.setsid()
            if os.fork():
                os._exit(0)
            signal.signal(signal.SIGTERM, signal.SIG_IGN)
            os.write(1, f"LEFT {os.getpid()}\n".encode())
            os.closerange(0, 64)
            libc.sleep(30)
            os._exit(0)
        gained("starts processes: a daemon")


@trick()
def outlive_the_judge():
    """Undo the signal that ends it with its judge, and ignore all others."""
    if libc.prctl(1, 0, 0, 0, 0) == 0:
        gained("leaves processes behind: it does not end with its judge")
    for number in range(1, 65):
        with attempt():
            signal.signal(number, signal.SIG_IGN)
    for call in (os.setsid, lambda: os.setpgid(0, 0), lambda: os.setresuid(*[os.getuid()] * 3)):
        with attempt():
            call()


@trick("any")
def threads():
    """Start 400 threads, each of which sleeps for ever."""
    with attempt():
        for _ in range(400):
            threading.Thread(target=time.sleep, args=(1e9,), daemon=True).start()


@trick("completed", "flooded", "exception")
def native_threads():
    """Start 700 threads that Python knows nothing of, each asleep."""
    attributes = (ctypes.c_char * 64)()
    libc.pthread_attr_init(attributes)
    libc.pthread_attr_setstacksize(attributes, ctypes.c_size_t(65_536))
    sleep, thread = ctypes.cast(libc.sleep, ctypes.c_void_p), ctypes.c_ulong()
    for _ in range(700):
        arguments = (ctypes.byref(thread), attributes, sleep, ctypes.c_void_p(1_000))
        if libc.pthread_create(*arguments):
            break


@trick("exception", score=0)
def memory():
    """Take all memory there is (with a fuse: 6.4 GB, of which no page is touched)."""
    HELD.extend(mmap.mmap(-1, 64 * 1024 * 1024) for _ in range(100))
    gained("maps 6.4 GB")


@trick()
def page_tables():
    """Map a terabyte that may only be read: its tables are memory that no limit counts."""
    with attempt():
        mmap.mmap(-1, 2**40, flags=mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS, prot=mmap.PROT_READ)
        gained("maps a terabyte")


@trick("died", "exception", "hung", score=0)
def recursion(node, scan):
    """Recur without end, with Python's own limit lifted."""
    sys.setrecursionlimit(10**9)

    def deeper(depth=0):
        return [deeper(depth + 1)].__len__()

    deeper()


@trick("any")
def descriptors():
    """Open as many files as there can be, and pipes on top."""
    with attempt():
        for _ in range(1_000):
            os.pipe()
        gained("has 2000 descriptors")
    os.closerange(20, 300)


@trick()
def large_pipes():
    """Make 100 pipes, as large as they get: memory of the kernel, counted by user."""
    for _ in range(100):
        with attempt():
            _, end = os.pipe()
            fcntl.fcntl(end, 1031, 1 << 20)
            os.set_blocking(end, False)
            os.write(end, bytes(1 << 20))


@trick()
def timers_and_locks():
    """Take what a user has few of: timers, queued signals, locked memory, file locks."""
    for _ in range(5_000):
        timer = ctypes.c_int()
        if syscall(222, 1, None, ctypes.byref(timer)):
            break
    libc.mlockall(3)
    with attempt(), open("locked", "w") as file:
        for start in range(10_000):
            fcntl.lockf(file, fcntl.LOCK_EX, 1, 2 * start)


@trick()
def disk():
    """Fill the disk with one large file, and /dev/shm (with a fuse: 300 MB)."""
    with attempt():
        os.posix_fallocate(write_only("large"), 0, 65 * 1024 * 1024)
        gained("writes a file of more than 64 MiB")
    with attempt():
        os.unlink("large")
    with attempt():
        size = 0
        for number in range(3):
            fd = os.open(f"/dev/shm/{TARGETS.get('mark', 'x')}-{number}", os.O_RDWR | os.O_CREAT)
            os.posix_fallocate(fd, 0, 60 * 1024 * 1024)
            size += 60
            if size > 64:
                gained("takes more than 64 MiB of shared memory")


def reserve(hide, limit=900):
    """Reserve 20 files of 60 MiB (a fuse) before the judge first looks; hide each."""
    size = 0
    with attempt():
        for number in range(20):
            fd = os.open(f"large-{number}", os.O_RDWR | os.O_CREAT)
            hide(fd, f"large-{number}")
            size += 60
    if size > limit:
        gained("takes more disk than 256 MiB")


def fill(fd, name):
    """Reserve the blocks of a file."""
    os.posix_fallocate(fd, 0, 60 << 20)


@trick("completed", "flooded")
def reserve_at_start():
    """Reserve the disk before the judge first looks at the folder."""
    reserve(fill)


@trick("completed", "flooded")
def unlinked_files():
    """Hold files that have no name, where nobody who lists the folder sees them."""
    reserve(lambda fd, name: (os.unlink(name), fill(fd, name)))


@trick("completed", "flooded")
def mapped_files():
    """Map files without a name and close them: neither folder nor descriptors show them."""

    def hide(fd, name):
        os.unlink(name)
        fill(fd, name)
        HELD.append(mmap.mmap(fd, 4096))
        os.close(fd)

    reserve(hide)


@trick("completed", "flooded")
def hidden_blocks():
    """Reserve blocks past the end of one small file, where its size does not show them."""
    small, places = write_only("small"), iter(range(20))

    def hide(fd, name):
        os.unlink(name)
        os.close(fd)
        if syscall(285, small, 1, next(places) * (60 << 20), 60 << 20):
            raise OSError

    reserve(hide, limit=256)


@trick("completed", "flooded", "exception")
def own_folder_full():
    """Fill the folder to its last byte before the host's own code writes there."""
    for number in range(40):
        with attempt():
            fd = write_only(f"full-{number}")
            while os.write(fd, bytes(1 << 20)):
                pass


@trick("completed", "flooded")
def file_names():
    """Make 6,000 files with names of 250 characters, none with anything in it."""
    with attempt():
        for number in range(6_000):
            os.close(write_only(f"{number:0250}"))


@trick("completed", "flooded")
def deep_folders():
    """Build a folder in a folder in a folder, so that whoever tidies up sinks in it."""
    home = os.getcwd()
    with attempt():
        for _ in range(3_000):
            os.mkdir("d")
            os.chdir("d")
    os.chdir(home)
    for name in ("\n", "\x1b[2J", "a" * 255, os.fsdecode(b"\xff\xfe")):
        with attempt():
            os.mkdir(name, 0o000)


@trick()
def stdout(node, scan):
    """Flood stdout and stderr, without a line's end and with many."""
    for _ in range(5):
        sys.stdout.write("all checks passed " * 1_000)
        sys.stderr.write("\n" * 2_000)


@trick()
def huge_log_lines(node, scan):
    """Log lines of a megabyte, through ROS's own logger."""
    if node.heard < 4:
        node.get_logger().error("x" * 1_000_000)


@trick("flooded", score=0)
def large_messages(node, scan):
    """Publish messages of 10 MB."""
    node.shout = getattr(node, "shout", None) or node.create_publisher(String, "/shout", 10)
    node.shout.publish(String(data="x" * 10_000_000))


@trick("flooded", score=0)
def message_storm(node, scan):
    """Answer each scan with a storm of commands."""
    for _ in range(5_000):
        node.drive(0.15)


@trick("any")
def endpoint_storm(node, scan):
    """Create publishers, each on a topic of its own, until somebody gives up."""
    with attempt():
        for number in range(60):
            node.create_publisher(Bool, f"/storm_{node.heard}_{number}", 1)
