"""Who may run beside whom."""

import fcntl
import threading
from functools import partial

import pytest

from grader.trial import exclusive
from grader.trial.exclusive import TrialLock


def test_many_may_be_there_at_once() -> None:
    lock = TrialLock()
    with lock.held(alone=False), lock.held(alone=False):
        pass


def test_on_a_shared_network_trials_are_of_one_process() -> None:
    lock, only = TrialLock(), fcntl.LOCK_EX | fcntl.LOCK_NB
    held = partial(lock.held, alone=False, shared_network=True)
    with open(exclusive.__file__, "rb") as another:
        with held():
            with held(), pytest.raises(BlockingIOError):
                fcntl.flock(another, only)
            with pytest.raises(BlockingIOError):
                fcntl.flock(another, only)
        fcntl.flock(another, only)


def test_one_alone_waits_for_the_others_and_goes_before_later_ones() -> None:
    lock, order = TrialLock(), []
    asked = threading.Event()

    def alone() -> None:
        asked.set()
        with lock.held(alone=True):
            order.append("alone")

    def late() -> None:
        with lock.held(alone=False):
            order.append("late")

    threads = [threading.Thread(target=alone), threading.Thread(target=late)]
    with lock.held(alone=False):
        threads[0].start()
        asked.wait()
        while not lock.entering.locked():  # the first thread is on its way there
            pass
        threads[1].start()
        order.append("first")
    for thread in threads:
        thread.join()

    assert order == ["first", "alone", "late"]
