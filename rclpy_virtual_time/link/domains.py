"""DDS domains: a number for each live trial, because trials in one domain hear each other."""

import contextlib
import random
from collections.abc import Iterator
from pathlib import Path

from rclpy_virtual_time.link.errors import EngineError
from rclpy_virtual_time.link.locks import held

DOMAINS = range(1, 102)  # above 101 the ports are Linux's own for outgoing connections
# UDP ports of a domain, by the DDSI-RTPS specification (OMG formal/2022-04-01, 9.6.2.1)
PORT_BASE, DOMAIN_GAIN = 7400, 250
_PORT_TABLES = ("/proc/net/udp", "/proc/net/udp6")


@contextlib.contextmanager
def own_domain() -> Iterator[int]:
    """Hold a domain that no other trial on this machine, and no other ROS program, is in.

    Raises EngineError: there is none left.
    """
    taken = domains_in_use()
    candidates = [domain for domain in DOMAINS if domain not in taken]
    random.SystemRandom().shuffle(candidates)
    for domain in candidates:
        with held(f"domain/{domain}") as mine:
            if mine:
                yield domain
                return
    raise EngineError("no free DDS domain: too many ROS programs or live trials on this machine")


def domains_in_use() -> set[int]:
    """Return the domains of which some program on this machine has a port."""
    ports = set()
    for table in _PORT_TABLES:
        with contextlib.suppress(OSError):
            for line in Path(table).read_text().splitlines()[1:]:
                ports.add(int(line.split()[1].rpartition(":")[2], 16))
    return {(port - PORT_BASE) // DOMAIN_GAIN for port in ports if port >= PORT_BASE}
