"""Who may run beside whom."""

import threading

from grader.trial.exclusive import Crowd


def test_many_may_be_there_at_once() -> None:
    crowd = Crowd()
    with crowd.joined(alone=False), crowd.joined(alone=False):
        pass


def test_one_alone_waits_for_the_others_and_goes_before_later_ones() -> None:
    crowd, order = Crowd(), []
    asked = threading.Event()

    def alone() -> None:
        asked.set()
        with crowd.joined(alone=True):
            order.append("alone")

    def late() -> None:
        with crowd.joined(alone=False):
            order.append("late")

    threads = [threading.Thread(target=alone), threading.Thread(target=late)]
    with crowd.joined(alone=False):
        threads[0].start()
        asked.wait()
        while not crowd.somebody_waits_alone:  # the first thread is on its way there
            pass
        threads[1].start()
        order.append("first")
    for thread in threads:
        thread.join()

    assert order == ["first", "alone", "late"]
