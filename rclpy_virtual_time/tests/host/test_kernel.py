"""The kernel alone: threads, locks and waits in virtual time."""

import pytest
from alone import run

# What a program does, and what it says and when.
PROGRAMS = {
    "sleepers wake in order of time then of arrival": ("""
        def sleeper(name, seconds):
            time.sleep(seconds)
            say(name)
        plan = [('c', 0.3), ('a', 0.1), ('b1', 0.2), ('b2', 0.2)]
        all = [threading.Thread(target=sleeper, args=entry) for entry in plan]
        for thread in all: thread.start()
        for thread in all: thread.join()
        say('joined')
    """, [[0.1, "a"], [0.2, "b1"], [0.2, "b2"], [0.3, "c"], [0.3, "joined"]]),
    "locks are handed on in order": ("""
        lock = threading.Lock()
        def worker(name):
            with lock:
                time.sleep(0.1)
                say(name)
        all = [threading.Thread(target=worker, args=(n,)) for n in 'abc']
        for thread in all: thread.start()
        for thread in all: thread.join()
    """, [[0.1, "a"], [0.2, "b"], [0.3, "c"]]),
    "timeouts of locks queues events and joins": ("""
        lock = threading.Lock(); lock.acquire()
        say(lock.acquire(timeout=0.1))
        say(threading.Event().wait(0.1))
        try: queue.Queue().get(timeout=0.1)
        except queue.Empty: say('empty')
        try: queue.SimpleQueue().get(timeout=0.1)
        except queue.Empty: say('empty')
        thread = threading.Thread(target=time.sleep, args=(1,)); thread.start()
        thread.join(0.1); say(thread.is_alive())
        thread.join(); say(thread.is_alive())
    """, [[0.1, False], [0.2, False], [0.3, "empty"], [0.4, "empty"], [0.5, True], [1.4, False]]),
    "misuse is refused as usual": ("""
        try: threading.Lock().release()
        except RuntimeError as error: say(str(error))
        try: threading.current_thread().join()
        except RuntimeError as error: say(str(error))
    """, [[0.0, "release unlocked lock"], [0.0, "cannot join current thread"]]),
    "rlock condition barrier semaphore": ("""
        rlock = threading.RLock()
        with rlock, rlock: say('in twice')
        barrier = threading.Barrier(2)
        def other():
            time.sleep(0.1)
            barrier.wait()
        threading.Thread(target=other).start()
        barrier.wait(); say('met')
        semaphore = threading.Semaphore(1)
        semaphore.acquire(); say(semaphore.acquire(timeout=0.1))
    """, [[0.0, "in twice"], [0.1, "met"], [0.2, False]]),
}  # fmt: skip


@pytest.mark.parametrize(("source", "said"), PROGRAMS.values(), ids=PROGRAMS)
def test_threads_take_turns_in_virtual_time(source: str, said: list[object]) -> None:
    assert run(source) == said


def test_a_cached_property_that_sleeps_is_computed_once() -> None:
    assert run("""
        import functools
        class Agent:
            @functools.cached_property
            def model(self):
                say('loading'); time.sleep(0.5)
                return object()
        agent, seen = Agent(), []
        threads = [threading.Thread(target=lambda: seen.append(agent.model)) for _ in range(2)]
        for thread in threads: thread.start()
        for thread in threads: thread.join()
        say('loaded')
    """)[0] == [0.0, "loading"]
