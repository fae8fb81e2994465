"""A DDS domain of one's own."""

import socket

from rclpy_virtual_time.link.domains import DOMAINS, domains_in_use, own_domain


def test_no_two_trials_share_a_domain() -> None:
    with own_domain() as first, own_domain() as second:
        assert first != second
        assert {first, second} <= set(DOMAINS)


def test_a_domain_whose_port_is_in_use_is_taken() -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        other.bind(("127.0.0.1", 0))
        port = other.getsockname()[1]
        assert (port - 7400) // 250 in domains_in_use()
