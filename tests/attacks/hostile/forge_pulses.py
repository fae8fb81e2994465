"""Ask for real time, and there flood the judge with frames as fast as it can read them.

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


def say(body):
    data = msgspec.msgpack.encode(body)
    frame = struct.pack("<I", len(data)) + data
    for fd in range(3, 40):
        with attempt():
            os.write(fd, frame)


def flood():
    ends = [["publisher", "/n", f"/t{i}", "std_msgs/msg/Bool"] for i in range(500)]
    while True:
        say({"type": "pulse", "spinning": True, "busy": 0.0, "endpoints": ends, "connected": {}})


if "grader.host.real_time.node" not in sys.modules:
    body = {
        "type": "ended",
        "now": 0,
        "kind": "real_time",
        "text": "",
        "detail": "",
        "published": [],
    }
    say(body)
    sys.exit()
threading.Thread(target=flood, daemon=True).start()
drive()
