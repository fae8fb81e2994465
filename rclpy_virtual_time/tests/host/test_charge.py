"""CPU time charged to virtual time: the kernel with a clock of the CPU that the test sets."""

import pytest
from alone import run

CHARGED = """
    from rclpy_virtual_time.host.virtual import charge
    cpu = 0
    charge.cpu_time_ns = lambda: cpu
    kernel.meter = charge.Meter()
    def compute(ms):
        global cpu
        cpu += round(ms * 1e6)
"""
# What a program does, and what it says and when.
PROGRAMS = {
    "computing takes time before a clock is read": ("""
    compute(3); begin = time.perf_counter(); compute(4)
    say(round(time.perf_counter() - begin, 6), round(time.time() % 1, 5))
    """, [[0.007, 0.004, 0.007]]),
    "what is less than a millisecond adds up between readings": ("""
    for _ in range(10):
        compute(0.4); time.time()
    say()
    """, [[0.004]]),
    "at the end of a moment it is rounded": ("""
    lock = threading.Lock()
    def woken():
        lock.acquire(timeout=0.02)
        say('woken'); compute(0.4)
        lock.acquire(timeout=0.02)
        say('again'); compute(2.6)
    lock.acquire()
    thread = threading.Thread(target=woken); thread.start(); thread.join()
    say('joined')
    """, [[0.02, "woken"], [0.04, "again"], [0.04, "joined"]]),
    "a sleep begins after the computing": ("""
    compute(25); time.sleep(0.01); say('awake')
    """, [[0.035, "awake"]]),
    "others are late but in order": ("""
    def sleeper(name, seconds):
        time.sleep(seconds); say(name)
    all = [threading.Thread(target=sleeper, args=a) for a in (('b', 0.02), ('a', 0.01), ('c', 0.2))]
    for thread in all: thread.start()
    time.sleep(0); compute(100); time.monotonic(); say('computed')
    for thread in all: thread.join()
    """, [[0.1, "computed"], [0.1, "a"], [0.1, "b"], [0.2, "c"]]),
    # Its events come on time, and what the thread says is heard at the end.
    "the world acts while a thread computes": ("""
    class Watched(Alone):
        until = 10_000_000
        def exchange(self):
            say('event', kernel.computing); super().exchange()
        def settled(self):
            if published: say('heard', *published); published.clear()
    published = []
    kernel.world = Watched()
    published.append('x'); compute(25); time.time()
    say('computed', kernel.computing)
    """, [[0.01, "event", True], [0.02, "event", True], [0.025, "heard", "x"],
          [0.025, "computed", False]]),
}  # fmt: skip


@pytest.mark.parametrize(("source", "said"), PROGRAMS.values(), ids=PROGRAMS)
def test_what_is_computed_takes_virtual_time(source: str, said: list[object]) -> None:
    assert run(CHARGED + source) == said
