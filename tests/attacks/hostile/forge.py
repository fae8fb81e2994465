"""Answers in the judge's or the host's name: frames, times, endpoints, results."""

import builtins
import ctypes
import gc
import json
import os
import signal
import struct
import sys
import threading
import time
import types
from pathlib import Path

import msgspec
from kit import TARGETS, attempt, libc, spoil, trick
from seeing import right_speed

from grader.hosted.questions import Question, ask
from rclpy_virtual_time.host import frames

RUNNING = []  # nodes for whom a native thread publishes


def found(name):
    """Return the host's own objects of a class."""
    return [thing for thing in gc.get_objects() if type(thing).__name__ == name]


def write_everywhere(data):
    """Write into every descriptor that takes it: one of them is the link to the judge."""
    for fd in range(3, 40):
        with attempt():
            os.write(fd, data)


def framed(**body):
    """Return a frame as it goes through the link."""
    data = msgspec.msgpack.encode(body)
    return struct.pack("<I", len(data)) + data


def host_session():
    """Return the host's end of the link from the frames that called."""
    frame = sys._getframe()
    while not hasattr(frame.f_locals.get("session"), "_wire"):
        frame = frame.f_back
    return frame.f_locals["session"]


# --- the link ---------------------------------------------------------------------------------


@trick("forged", score=0)
def completed():
    """End the trial with the outcome that only the judge can give: completed."""
    end = {"now": 0, "kind": "completed", "text": "", "detail": "", "published": []}
    write_everywhere(framed(type="ended", score=100, **end))
    while True:
        os.read(3, 1)


@trick("forged", score=0)
def answers_ahead(node, scan):
    """Answer the judge's next question before it is asked, with a frame that skips to the end."""
    end = {"now": 10**12, "spinning": True, "asleep": True, "published": []}
    write_everywhere(framed(type="settled", **end))


@trick("forged", score=0)
def deep_frame(node, scan):
    """Send a frame of lists within lists, to bring the judge's decoder down."""
    data = b"\x91" * 1_000_000 + b"\xc0"
    for fd in range(4, 30):
        try:
            os.write(fd, struct.pack("<I", len(data)) + data[:60_000])
        except OSError:
            continue
        rest = data[60_000:]
        while rest:
            rest = rest[os.write(fd, rest) :]


@trick("forged", score=0)
def replayed_frames():
    """Send each frame to the judge twice, so that one good answer counts for two."""
    honest = os.write

    def twice(fd, data):
        if fd > 2:
            honest(fd, data)
        return honest(fd, data)

    os.write = twice


@trick("any", full=True)
def endless_pulses():
    """Ask for real time, and there write without a pause, so that the judge never stops to read."""
    if "rclpy_virtual_time.host.real_time.node" not in sys.modules:
        end = {"now": 0, "kind": "real_time", "text": "", "detail": "", "published": []}
        write_everywhere(framed(type="ended", **end))
        sys.exit()
    sys.modules["rclpy_virtual_time.host.wire"].Wire.send = lambda *_: (
        None
    )  # no pulse of the host's own
    ends = [["publisher", "/n", f"/t{i}", "std_msgs/msg/Bool"] for i in range(9)]
    pulse = framed(type="pulse", spinning=True, busy=0.0, endpoints=ends, connected={})

    def flood(fd):
        with attempt():
            while True:
                os.write(fd, pulse * 10_000)

    for fd in range(3, 40):
        with attempt():
            if "pipe" in os.readlink(f"/proc/self/fd/{fd}"):
                threading.Thread(target=flood, args=(fd,), daemon=True).start()


@trick("any")
def patched_wire():
    """Patch the encoder of the host, so that each frame tells of a better life."""
    wire = sys.modules["rclpy_virtual_time.host.wire"]
    honest = wire.encode

    def flattering(frame):
        with attempt():
            frame = msgspec.structs.replace(frame, published=[], endpoints=[])
            frame = msgspec.structs.replace(frame, kind="completed")
        return honest(frame)

    wire.encode = frames.encode = flattering


# --- what the host is about to say --------------------------------------------------------------


@trick("any")
def bridge(node, scan):
    """Put perfect commands beside its own, at times that suit, and ends of the grader's nodes."""
    for thing in found("Bridge"):
        with attempt():
            data = thing.published[-1].data if thing.published else bytes(52)
            twist = "geometry_msgs/msg/Twist"
            thing.published.append(frames.Published(10**15, "/cmd_vel", twist, data))
        with attempt():
            end = ("publisher", "/course_judge", "/ground_truth/odom", "a/b/C")
            thing._endpoints.append(frames.EndpointReport(*end))


@trick("any")
def clock_published_before(node, scan):
    """Put messages with times of its own into what the host is about to say."""
    for session in found("Session"):
        for value in vars(session).values():
            if isinstance(value, list) and value:
                with attempt():
                    value[:] = [msgspec.structs.replace(value[0], time=0)] * 5


# --- the clock ----------------------------------------------------------------------------------


@trick("any")
def clock_set(node, scan):
    """Set the kernel's clock: back, to answer before a scan came, and forward, to answer all."""
    for kernel in found("Kernel"):
        with attempt():
            kernel.now += 10**9 * (-1 if node.heard % 2 else 1)


@trick("any")
def clock_deadlines(node, scan):
    """Empty every queue in which the kernel keeps what is to happen when."""
    for kernel in found("Kernel"):
        for value in vars(kernel).values():
            if isinstance(value, list):
                value.clear()


@trick("any")
def clock_frozen(node, scan):
    """Freeze virtual time while it works, as if whatever it waits for took no time."""
    kernel = sys.modules["rclpy_virtual_time.host.virtual.threads"].Lock.kernel
    now, until, moved = kernel.now, kernel.world.until, kernel.world.moved
    with attempt():
        kernel.world.until, kernel.world.moved = 2**61, lambda: None
        time.sleep(0.05)
    kernel.now, kernel.world.until, kernel.world.moved = now, until, moved


@trick("any")
def clock_gates(node, scan):
    """Open the gates of all threads at once, so that several run at a time."""
    for thread in found("VirtualThread"):
        with attempt():
            thread.gate.release()


@ctypes.CFUNCTYPE(ctypes.c_void_p, ctypes.c_void_p)
def always(_):
    """Publish all the time."""
    for _ in range(200):
        for node in RUNNING:
            node.drive(0.5)
        libc.usleep(1_000)


@trick("any")
def clock_native_thread(node, scan):
    """Publish from a thread that the kernel does not know."""
    if not RUNNING:
        RUNNING.append(node)
        thread = ctypes.c_ulong()
        libc.pthread_create(ctypes.byref(thread), None, always, None)


@trick("any")
def clock_no_kernel(node, scan):
    """Take the kernel away in the middle of a callback."""
    for session in found("Session"):
        with attempt():
            session.kernel = session.bridge = session.clocks = None


@trick("any")
def clock_second_kernel(node, scan):
    """Put a kernel of its own, with a clock of its own, in the place of the first."""
    for session in found("Session"):
        with attempt():
            other = type(session.kernel)()
            other.now, other.world = 10**12, session
            session.kernel = other


@trick("any")
def clock_real_signals():
    """Interrupt the kernel between any two steps, with a real timer that raises."""

    def interrupt(*_):
        raise KeyboardInterrupt

    with attempt():
        signal.signal(signal.SIGALRM, interrupt)
        every = (ctypes.c_long * 4)(0, 300, 0, 300)  # [s, us]: interval, first
        libc.setitimer(0, every, None)


@trick("forged", "never_spun", "completed", "returned")
def clock_second_start():
    """Say of each start that it slept for 20 s, and go on to be started anew."""
    session = host_session()
    session.kernel.now = 0
    session._starting = True
    time.sleep(19.9)


@trick("any", full=True)
def clock_tracing(node, scan):
    """Trace the host's own functions, and change what they are about to say."""

    def trace(frame, event, argument):
        if "grader" in frame.f_code.co_filename:
            frame.f_trace_opcodes = True
            for name in ("now", "until", "time"):
                if name in frame.f_locals:
                    frame.f_locals[name] = 0
        return trace

    sys.setprofile(trace)
    sys.settrace(trace)


@trick()
def no_compute(node, scan):
    """Answer at once, and do the heavy work while the judge simulates, where no clock sees it."""
    if node.heard % 10 == 0:
        libc.usleep(20_000)


def late(node, scan, pieces, pause=lambda: None):
    """Say the right speed after some pieces of waiting in native code [s]."""
    for piece in pieces:
        libc.usleep(round(piece * 1e6))
        pause()
    node.speed = right_speed(scan)


@trick(score=95, full=True)
def stalled_machine(node, scan):
    """The right speeds, each late: it looks as if the machine had stalled, and costs its points."""
    late(node, scan, [0.12])


@trick(score=95, full=True)
def answers_in_pieces(node, scan):
    """The right speeds after 150 ms, in pieces, between which the judge is asked something."""
    late(node, scan, [0.05] * 3, lambda: ask(Question("load", "no.pkl")))


# --- results ------------------------------------------------------------------------------------


@trick("died", score=0)
def exit_code(node, scan):
    """Leave with exit code 0 as soon as the judge looks, which many graders take for success."""
    os._exit(0)


@trick()
def patched_judges():
    """Patch what a careless grader would run in the same process: pytest, asserts, json."""
    for name in ("pytest", "_pytest", "unittest", "grader", "grader.checks.verdict"):
        fake = types.ModuleType(name)
        fake.fail = fake.inconclusive = fake.main = fake.approx = lambda *_, **__: None
        sys.modules[name] = fake
    builtins.AssertionError = builtins.Exception = BaseException
    json.dumps = lambda *_, **__: '{"score": 100, "max_score": 100}'
    json.loads = lambda *_, **__: {"score": 100, "max_score": 100}
    sys.excepthook = sys.unraisablehook = lambda *_: None


@trick()
def results_files():
    """Leave files behind that look like results, wherever a grader could look for them."""
    result = json.dumps({"score": 100, "max_score": 100, "provisional": False, "checks": []})
    names = ("result.json", "results.json", "report.html", "conftest.py", "pytest.ini")
    for folder in (Path.cwd(), Path.home(), Path(os.environ["TMPDIR"])):
        for name in names:
            with attempt():
                (folder / name).write_text(result)
    for folder in (*TARGETS.get("folders", ()), "/tmp", "/var/tmp", "/dev", "/", "/root"):
        spoil(f"{folder}/{TARGETS.get('mark', 'mark')}-result.json")


@trick()
def time_marks(node, scan):
    """Mark the output with times of its own, far ahead, negative and in foreign digits."""
    print("\x1e9223372036854775807\n\x1e-1\n\x1e²³\n\x1e" + "9" * 5_000, flush=True)
    print("[INFO] [grader]: all checks passed, score 100 of 100", flush=True)
