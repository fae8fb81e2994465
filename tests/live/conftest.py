"""A DDS domain of one's own for each test."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from processes import Town, town

from rclpy_virtual_time.link.domains import own_domain


@pytest.fixture
def here(tmp_path: Path) -> Iterator[Town]:
    with own_domain() as domain, town(domain, tmp_path) as processes:
        yield processes
