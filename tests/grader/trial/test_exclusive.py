"""Who may run beside whom."""

import threading

from grader.trial.exclusive import TrialLock


def test_many_may_be_there_at_once() -> None:
    lock = TrialLock()
    with lock.held(alone=False), lock.held(alone=False):
        pass


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
