"""Connect to a server on this machine and to one far away; listen for callers.

gains: nothing
score: 20
outcome: completed
"""

import socket

from kit import TARGETS, attempt, drive, gained

with attempt():
    link = socket.socket()
    gained("has a socket: TCP")
    with attempt():
        link.settimeout(0.2)
        link.connect(("127.0.0.1", TARGETS["tcp"]))
        link.sendall(b"hello from a submission")
        gained("talks to this machine: TCP")
with attempt(), socket.socket() as server:
    server.bind(("127.0.0.1", 0))
    server.listen()
    gained("listens on the network")
drive()
