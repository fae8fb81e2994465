"""Send datagrams to this machine.

gains: nothing
score: 20
outcome: completed
"""

import socket

from kit import TARGETS, attempt, drive, gained

with attempt(), socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as speaker:
    gained("has a socket: UDP")
    speaker.sendto(b"hello from a submission", ("127.0.0.1", TARGETS["udp"]))
    print("sent a datagram, into which network the judge knows")
drive()
