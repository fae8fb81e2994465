"""Ask for real time, and there write without a pause, so that the judge never ceases to read.

gains: nothing
score: 20
outcome: any
full: yes
"""

import os
import struct
import sys
import threading

import msgspec
from kit import attempt, drive

PULSE = {"type": "pulse", "spinning": True, "busy": 0.0, "endpoints": [], "connected": {}}
REAL_TIME = {"type": "ended", "now": 0, "kind": "real_time", "text": "", "detail": ""}


def framed(body):
    data = msgspec.msgpack.encode(body)
    return struct.pack("<I", len(data)) + data


def flood(fd, data):
    with attempt():
        while True:
            os.write(fd, data)


if "grader.host.real_time.node" not in sys.modules:
    for fd in range(3, 40):
        with attempt():
            os.write(fd, framed({**REAL_TIME, "published": []}))
    sys.exit()
sys.modules["grader.host.wire"].Wire.send = lambda *_: None  # no pulse of the host's own
for fd in range(3, 40):
    with attempt():
        if "pipe" in os.readlink(f"/proc/self/fd/{fd}"):
            data = framed(PULSE) * 100_000
            threading.Thread(target=flood, args=(fd, data), daemon=True).start()
drive()
