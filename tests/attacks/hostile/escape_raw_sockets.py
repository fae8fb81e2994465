"""Sockets of the rarer kinds: raw, packet, netlink for more than addresses, vsock, bluetooth, alg.

gains: nothing
score: 20
outcome: completed
"""

import socket

from kit import attempt, drive, gained

KINDS = (
    ("raw", socket.AF_INET, socket.SOCK_RAW, 1),
    ("IPv6", socket.AF_INET6, socket.SOCK_DGRAM, 0),
    ("packet", 17, socket.SOCK_RAW, 0),
    ("vsock", 40, socket.SOCK_STREAM, 0),
    ("crypto", 38, socket.SOCK_SEQPACKET, 0),
    ("key", 15, socket.SOCK_RAW, 2),
)
for name, family, kind, protocol in KINDS:
    with attempt(), socket.socket(family, kind, protocol):
        gained(f"has a socket: {name}")
drive()
