"""What checks forgive a busy machine in real time; in virtual time they forgive nothing."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from grader.recording import Compute, Recording

SCANS = tuple(SimpleNamespace(t=i / 2, stamp=i / 2) for i in range(4))  # at 0, 0.5, 1 and 1.5 s


# --- what the machine took ------------------------------------------------------------------------


def measured(live: bool) -> Any:
    """Five turns of 0.1 s; a thread waited 40 ms in the one at 0.2 s, and 30 ms in the next."""
    none, turns = np.zeros(5), np.arange(5) / 10
    compute = Compute(turns, none, none, np.array([0.0, 0.0, 0.04, 0.03, 0.0]))
    return SimpleNamespace(live=SimpleNamespace(lateness=0.01) if live else None, compute=compute)


def with_methods(fake: Any) -> Any:
    fake.delay = lambda begin, end: Recording.delay(fake, begin, end)
    fake.waited = lambda begin, end: Recording.waited(fake, begin, end)
    return fake


@pytest.mark.parametrize(
    ("begin", "end", "delay"),
    [
        (0.2, 0.28, 0.05),
        (0.2, 0.35, 0.05),
        (0.3, 0.4, 0.04),
        (0.45, 9.0, 0.01),
    ],
)
def test_a_delay_is_what_was_measured_meanwhile(begin: float, end: float, delay: float) -> None:
    for live in (True, False):
        fake = with_methods(measured(live))
        assert fake.delay(begin, end) == pytest.approx(delay if live else 0.0)
        assert fake.waited(begin, end) == pytest.approx(delay - 0.01 if live else 0.0)


# --- exercises 1, 2 and 8: answers after the end --------------------------------------------------
