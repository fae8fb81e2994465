"""CPU time charged to virtual time: the kernel with a clock of the CPU that the test sets."""

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


def test_computing_takes_time_before_a_clock_is_read() -> None:
    assert run(f"""{CHARGED}
    compute(3); begin = time.perf_counter(); compute(4)
    say(round(time.perf_counter() - begin, 6), round(time.time() % 1, 5))
    """) == [[0.007, 0.004, 0.007]]


def test_what_is_less_than_a_millisecond_adds_up_between_readings() -> None:
    assert run(f"""{CHARGED}
    for _ in range(10):
        compute(0.4); time.time()
    say()
    """) == [[0.004]]


def test_at_the_end_of_a_moment_it_is_rounded() -> None:
    assert run(f"""{CHARGED}
    lock = threading.Lock()
    def woken():
        lock.acquire(timeout=0.02)
        say('woken'); compute(0.4)
        lock.acquire(timeout=0.02)
        say('again'); compute(2.6)
    lock.acquire()
    thread = threading.Thread(target=woken); thread.start(); thread.join()
    say('joined')
    """) == [[0.02, "woken"], [0.04, "again"], [0.04, "joined"]]


def test_a_sleep_begins_after_the_computing() -> None:
    assert run(f"{CHARGED}\n    compute(25); time.sleep(0.01); say('awake')") == [[0.035, "awake"]]


def test_others_are_late_but_in_order() -> None:
    assert run(f"""{CHARGED}
    def sleeper(name, seconds):
        time.sleep(seconds); say(name)
    all = [threading.Thread(target=sleeper, args=a) for a in (('b', 0.02), ('a', 0.01), ('c', 0.2))]
    for thread in all: thread.start()
    time.sleep(0); compute(100); time.monotonic(); say('computed')
    for thread in all: thread.join()
    """) == [[0.1, "computed"], [0.1, "a"], [0.1, "b"], [0.2, "c"]]


def test_the_world_acts_while_a_thread_computes() -> None:
    """Its events come on time, and what the thread says is heard at the end."""
    assert run(f"""{CHARGED}
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
    """) == [
        [0.01, "event", True],
        [0.02, "event", True],
        [0.025, "heard", "x"],
        [0.025, "computed", False],
    ]
