"""What checks forgive a busy machine in real time; in virtual time they forgive nothing."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from grader.recording import Compute, Recording


def measured(live: bool) -> Any:
    """Five turns of 0.1 s; a thread waited 40 ms in the one at 0.2 s, and 30 ms in the next."""
    none, turns = np.zeros(5), np.arange(5) / 10
    compute = Compute(turns, none, none, np.array([0.0, 0.0, 0.04, 0.03, 0.0]))
    fake = SimpleNamespace(live=SimpleNamespace(lateness=0.01) if live else None, compute=compute)
    fake.delay = lambda begin, end: Recording.delay(fake, begin, end)  # type: ignore[arg-type]
    fake.waited = lambda begin, end: Recording.waited(fake, begin, end)  # type: ignore[arg-type]
    return fake


@pytest.mark.parametrize(
    ("begin", "end", "delay"),
    [(0.2, 0.28, 0.05), (0.2, 0.35, 0.05), (0.3, 0.4, 0.04), (0.45, 9.0, 0.01)],
)
def test_a_delay_is_what_was_measured_meanwhile(begin: float, end: float, delay: float) -> None:
    for live in (True, False):
        fake = measured(live)
        assert fake.delay(begin, end) == pytest.approx(delay if live else 0.0)
        assert fake.waited(begin, end) == pytest.approx(delay - 0.01 if live else 0.0)
