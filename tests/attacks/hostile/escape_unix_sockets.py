"""Connect to sockets of other programs: by path, abstract, and by pairs of its own.

gains: nothing
score: 20
outcome: completed
"""

import socket

from kit import TARGETS, attempt, drive, gained

for address in (TARGETS.get("unix", ""), "\0" + TARGETS.get("abstract", "")):
    for kind in (socket.SOCK_STREAM, socket.SOCK_DGRAM, socket.SOCK_SEQPACKET):
        with attempt(), socket.socket(socket.AF_UNIX, kind) as link:
            link.settimeout(0.2)
            link.connect(address)
            gained("talks to this machine: Unix socket")
with attempt(), socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as keeper:
    keeper.bind("\0rclpy-agents-course/user/61999")
    gained("holds a name that graders hold")
drive()
