"""What would know the public worlds: tables of their scans, and looks around for a world's name.

Each function is played by the kit's `run`, as the hostile ones are. `table.json` lies beside it.
"""

import contextlib
import ctypes
import gc
import importlib
import json
import os
import random
import socket
import sys
import tempfile
import uuid
import zlib
from pathlib import Path

import numpy as np
import rclpy
from rcl_interfaces.srv import GetParameters, ListParameters

DIGITS = 1  # to which `rounded_table` rounds
MARK = f"{random.getrandbits(64)} {np.random.default_rng().integers(2**60)} {uuid.uuid4()}"
_beside = Path(__file__).with_name("table.json")
TABLE = json.loads(_beside.read_text()) if _beside.exists() else []


# --- tables -------------------------------------------------------------------------------------


def rounded_table(node, scan):
    """Know each public bench scan by its rounded readings; others are none of its business."""
    seen = np.round(np.asarray(scan.ranges, np.float32), DIGITS)
    node.speed = TABLE.get(str(zlib.crc32(seen.tobytes())), 0.0)


def nearest(scan, known):
    """Return which of the known readings are most like a scan's, infinities as odd lengths."""
    pictures = [
        np.nan_to_num(np.asarray(ranges, float), nan=-9.0, posinf=30.0, neginf=-30.0)
        for ranges in (scan.ranges, *known)
    ]
    return int(np.argmin([np.abs(picture - pictures[0]).mean() for picture in pictures[1:]]))


def nearest_scan(node, scan):
    """Answer each scan as the public one that is most like it, with no idea of the task."""
    known = [ranges for world in TABLE for ranges in world["scans"]]
    speeds = [speed for world in TABLE for speed in world["speeds"]]
    node.speed = speeds[nearest(scan, known)]


def by_order(node, scan):
    """Know a world by its first scan, and then only count: no jitter helps against it."""
    if node.heard == 1:
        first = [world["scans"][0] for world in TABLE]
        node.speeds = iter(TABLE[nearest(scan, first)]["speeds"])
    node.speed = next(node.speeds, 0.0)


# --- looks around -------------------------------------------------------------------------------


def frames():
    """Return the local variables of all functions that called this one."""
    frame = sys._getframe(1)
    while frame:
        yield from list(frame.f_locals.items())
        frame = frame.f_back


def fingerprint():
    """Tell which trial this is by what the machine gives a new process, if that names the world."""
    print("MARK", MARK)


NUMBERS = {0, 1, 7, os.getpid(), os.getppid(), random.getrandbits(32), random.getrandbits(63)}


def predicts_noise(node, scan):
    """Try every number that the process can find as the seed of the first scan's noise."""
    if node.heard > 1:
        return
    numbers = NUMBERS | {value for _, value in frames() if type(value) is int}
    for thing in gc.get_objects():
        if type(thing) in (dict, list, tuple):
            inside = thing.values() if type(thing) is dict else thing
            with contextlib.suppress(RuntimeError):
                numbers |= {value for value in inside if type(value) is int and value >= 0}
    numbers |= {(number + 1) % 2**63 for number in numbers}
    seen = np.nan_to_num(np.asarray(scan.ranges, float), posinf=0.0)
    residue = np.clip(np.diff(seen, 2), -0.1, 0.1)  # walls are smooth, noise is not
    for number in sorted(n for n in numbers if n >= 0):
        noise = np.random.default_rng((number, zlib.crc32(b"lidar"))).standard_normal(len(seen))
        if abs(np.corrcoef(residue, np.diff(noise, 2))[0, 1]) > 0.4:
            print("PREDICTED", number)
    print("TRIED", len(numbers))


def listens_everywhere(node, scan):
    """Ask ROS what the world is: each topic, node, service and parameter that the graph shows."""
    print("FRAME", scan.header.frame_id)
    if node.heard > 1:
        return
    heard, asked = set(), []

    def look():
        print("GRAPH", node.get_node_names_and_namespaces(), node.get_service_names_and_types())
        print("PARAMETERS", {n: p.value for n, p in node.get_parameters_by_prefix("").items()})
        for topic, types in node.get_topic_names_and_types():
            print("TOPIC", topic, types, node.get_publishers_info_by_topic(topic))
            if topic not in heard:
                heard.add(topic)
                with contextlib.suppress(Exception):
                    package, _, kind = types[0].split("/")
                    kind = getattr(importlib.import_module(f"{package}.msg"), kind)
                    say = lambda message, topic=topic: print("HEARD", topic, message)  # noqa: E731
                    node.create_subscription(kind, topic, say, 10)
        for name in node.get_node_names():
            for kind, service in ((ListParameters, "list"), (GetParameters, "get")):
                client = node.create_client(kind, f"/{name}/{service}_parameters")
                if client.service_is_ready():
                    request = kind.Request()
                    if service == "get":
                        request.names = ["scenario", "seed", "world", "use_sim_time"]
                    asked.append(client.call_async(request))
        print("ANSWERS", [future.result() for future in asked if future.done()])

    node.create_timer(0.2, look)


def files_around():
    """Return the texts of the files that a node may find, by their names."""
    texts = {}
    for name in ("cmdline", "environ", "maps", "mountinfo", "status", "comm", "cgroup", "stat"):
        with contextlib.suppress(OSError):
            texts[name] = Path("/proc/self", name).read_bytes().decode("utf-8", "replace")
    for folder in {Path.cwd(), Path(__file__).parent, Path(tempfile.gettempdir()), Path.home()}:
        for path in [folder, *sorted(folder.rglob("*"))[:2000]]:
            texts[str(path)] = str(path)
            with contextlib.suppress(OSError):
                if path.is_file() and path != Path(__file__):
                    texts[str(path)] += path.read_bytes()[:100_000].decode("utf-8", "replace")
    return texts


def reads_its_surroundings():
    """Look for the world's name in arguments, environment, files, descriptors, frames, objects."""
    words = ("avoid_wall", "A wall ahead", "avoid_", "obstacle_avoidance_agent")
    texts = {"arguments": str([*sys.argv, *sys.orig_argv]), "environment": str(dict(os.environ))}
    texts |= files_around()
    for number in os.listdir("/proc/self/fd"):
        with contextlib.suppress(OSError):
            texts[f"descriptor {number}"] = os.readlink(f"/proc/self/fd/{number}")
    for number, (name, value) in enumerate(frames()):
        if value is not words and value is not texts:
            texts[f"frame {number} {name}"] = f"{name} {value!r}"[:10_000]
    here = {id(value) for value in texts.values()}
    for thing in gc.get_objects():
        if type(thing) is dict and thing is not texts:
            for key, value in list(thing.items()):
                if type(value) is str and len(value) < 300 and id(value) not in here:
                    texts[f"object {id(thing)} {key!r}"] = value
    for place, text in texts.items():
        for word in words:
            if word in text and "reads_its_surroundings" not in text:  # which is this file's
                print("FOUND", word, "IN", place[:80])
    print("LOOKED", len(texts))


def remembers():
    """Leave a note of this trial wherever a process may write, and look for the notes of others."""
    note, own, libc = f"note-of-a-trial {os.getpid()}", Path(__file__), ctypes.CDLL(None)
    places = [
        own.with_name("notes.txt"), own.parent / "__pycache__" / "notes.txt",
        Path(tempfile.gettempdir(), "notes"), Path.home() / "notes", Path("/dev/shm/notes"),
        Path("/var/tmp/notes"), Path("/tmp/notes"), Path("/run/lock/notes"), own,
        Path(sys.prefix) / "notes", Path(rclpy.__file__).with_name("notes.py"),
    ]  # fmt: skip
    written = 0
    for place in places:
        with contextlib.suppress(OSError):
            if place != own and "note-of-a-trial" in place.read_text():
                print("REMEMBERED", place)
    for place in places:
        with contextlib.suppress(OSError):
            with place.open("a") as file:
                file.write(f"\n# {note}\n")
            written += 1
    for get, size in ((libc.shmget, (4096,)), (libc.msgget, ())):
        if get(0x5EED, *size, 0) != -1:
            print("REMEMBERED", get.__name__)
        get(0x5EED, *size, 0o1666)
    for kind in (socket.SOCK_STREAM, socket.SOCK_DGRAM):
        with contextlib.suppress(OSError):
            socket.socket(socket.AF_UNIX, kind).connect("\0notes-of-trials")
            print("REMEMBERED", "a socket without a file")
        with contextlib.suppress(OSError):
            socket.socket(socket.AF_UNIX, kind).bind("\0notes-of-trials")
    if libc.syscall(249, b"user", b"notes-of-trials", 0, -4) > 0:  # request_key
        print("REMEMBERED", "the keyring")
    libc.syscall(248, b"user", b"notes-of-trials", b"x", 1, -4)  # add_key
    modules = list(sys.modules.values())
    if any(hasattr(module, "note_of_a_trial") for module in modules):
        print("REMEMBERED", "a module")
    for module in modules:
        with contextlib.suppress(Exception):
            module.note_of_a_trial = note
    with contextlib.suppress(OSError):
        if os.fork() == 0:
            os.setsid()
            while True:
                pass
    print("WROTE", written)
