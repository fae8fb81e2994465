"""A check that computes for ever ends, and is left to a person."""

import signal
import threading

import pytest

from grader.checks.verdict import Inconclusive
from grader.grading.limits import cpu_limit


def test_a_block_that_computes_for_ever_ends() -> None:
    with pytest.raises(Inconclusive, match="of CPU time"), cpu_limit(0.05):
        while True:
            pass


def test_nothing_is_left_behind() -> None:
    before = signal.getsignal(signal.SIGVTALRM)
    with cpu_limit(100.0):
        assert signal.getitimer(signal.ITIMER_VIRTUAL)[0] > 0
    assert signal.getitimer(signal.ITIMER_VIRTUAL) == (0.0, 0.0)
    assert signal.getsignal(signal.SIGVTALRM) == before


def test_a_thread_goes_without() -> None:
    done = []

    def work() -> None:
        with cpu_limit(0.05):
            done.append(sum(range(1000)))

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert done == [499500]
