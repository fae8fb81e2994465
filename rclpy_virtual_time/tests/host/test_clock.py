"""Whatever Python asks about time, or of chance, inside a host."""

import pytest
from alone import run

SECONDS = 1_700_000_000  # of the epoch in these tests


def test_every_clock_shows_the_same_time() -> None:
    """Each has moved on by what was slept, and each shows the time of day that ROS shows."""
    (shown,) = run("""
        import calendar, datetime, logging, os, uuid
        from datetime import date, datetime as Datetime, timezone
        MONOTONIC = {"CLOCK_MONOTONIC", "CLOCK_MONOTONIC_RAW", "CLOCK_BOOTTIME"}
        WALL = {"CLOCK_REALTIME", "CLOCK_TAI"}
        def wall():
            yield "time", time.time()
            yield "time_ns", time.time_ns() / 1e9
            yield "datetime.now", Datetime.now().timestamp()
            yield "datetime.now(utc)", Datetime.now(timezone.utc).timestamp()
            yield "utcnow", Datetime.utcnow().replace(tzinfo=timezone.utc).timestamp()
            yield "today", Datetime.today().timestamp()
            yield "module datetime", datetime.datetime.now().timestamp()
            yield "localtime", time.mktime(time.localtime())
            yield "localtime(None)", time.mktime(time.localtime(None))
            yield "gmtime", calendar.timegm(time.gmtime())
            yield "ctime", time.mktime(time.strptime(time.ctime()))
            yield "asctime", time.mktime(time.strptime(time.asctime()))
            yield "strftime", int(time.strftime("%s"))
            yield "uuid1", (uuid.uuid1().time - 0x01b21dd213814000) / 1e7
            yield "a log record", logging.makeLogRecord({}).created
            for name in sorted(WALL & set(dir(time))):
                yield name, time.clock_gettime(getattr(time, name))
                yield name + "_ns", time.clock_gettime_ns(getattr(time, name)) / 1e9
        def steady():
            for name in ("monotonic", "perf_counter"):
                yield name, getattr(time, name)()
                yield name + "_ns", getattr(time, name + "_ns")() / 1e9
            for name in sorted(MONOTONIC & set(dir(time))):
                yield name, time.clock_gettime(getattr(time, name))
        days = [str(date.today()), time.strftime("%Y-%m-%d"), str(Datetime.now().date())]
        kernel.world.until = 10**18  # nothing happens for days
        time.sleep(86_400.0 + 2.5)
        days += [str(date.today()), time.strftime("%Y-%m-%d"), str(Datetime.now().date())]
        processor = (time.process_time(), time.thread_time(),
                     time.clock_gettime(time.CLOCK_PROCESS_CPUTIME_ID))
        say(dict(wall()), dict(steady()), days, max(processor))
    """)
    _, wall, steady, days, processor = shown
    assert processor < 1_000.0  # sleep is not counted
    now = SECONDS + 86_402.5
    coarse = {"localtime", "localtime(None)", "gmtime", "ctime", "asctime", "strftime"}
    assert {name: now - int(name in coarse) / 2 for name in wall} == pytest.approx(wall, abs=1e-4)
    assert steady == pytest.approx(dict.fromkeys(steady, 1_000 + 86_402.5), abs=1e-4)
    assert days == ["2023-11-14"] * 3 + ["2023-11-15"] * 3


READINGS = """
    import asyncio, datetime, os, uuid
    loop = asyncio.new_event_loop()
    clocks = [time.time, time.time_ns, time.monotonic, time.monotonic_ns, time.perf_counter,
              time.perf_counter_ns, loop.time, datetime.datetime.now, datetime.datetime.utcnow,
              lambda: datetime.datetime.now(datetime.timezone.utc), lambda: os.times().elapsed,
              lambda: time.clock_gettime(time.CLOCK_REALTIME), lambda: uuid.uuid1().time,
              lambda: time.clock_gettime_ns(time.CLOCK_BOOTTIME)]
    def rising(values): return all(a < b for a, b in zip(values, values[1:]))
"""


def test_each_reading_is_later_than_the_one_before() -> None:
    """Also beside all other clocks, with or without time going on between them."""
    said = run(f"""{READINGS}
    time.sleep(0.0503)  # the world does something every 10 ms
    for clock in clocks:
        say(rising([clock() for _ in range(1000)]))
    rounds = []
    for _ in range(300):
        rounds.append([clock() for clock in clocks])
        time.sleep(1e-7 if len(rounds) % 2 else 0.0013)
    say(*[rising(column) for column in zip(*rounds)])
    """)
    assert [words for _, *words in said] == [[True]] * 14 + [[True] * 14]


def test_a_reading_is_never_later_than_what_is_due() -> None:
    """Two threads read while each other's moments come: all in one order, each in its time."""
    assert run("""
    seen, late = [], []
    def reads(wait, count):
        for _ in range(20):
            due = kernel.after(wait); time.sleep(wait)
            seen.append(time.time()); late.append(kernel.present - due)
            seen.extend(time.time() for _ in range(count))
    pool = [threading.Thread(target=reads, args=a) for a in ((0.001, 700), (2e-6, 5), (0.0004, 50))]
    for thread in pool: thread.start()
    for thread in pool: thread.join()
    say(all(a < b for a, b in zip(seen, seen[1:])), max(late))
    """)[0][1:] == [True, 0]


def test_a_wait_is_never_shorter_by_any_clock() -> None:
    ((_, *waited),) = run("""
    import asyncio
    waited = []
    for wait in (time.sleep, threading.Event().wait, lambda s: asyncio.run(asyncio.sleep(s))):
        for readings in (1, 2, 50):
            for _ in range(readings): before = time.perf_counter_ns()
            wait(0.01)
            waited.append(time.perf_counter_ns() - before)
    say(*waited)
    """)
    assert min(waited) >= 10_000_000, waited  # type: ignore[type-var]
    assert max(waited) < 13_500_000, waited  # type: ignore[operator,type-var]


def test_waiting_for_a_date_ends() -> None:
    ((now,),) = run("""
        from datetime import datetime, timedelta
        end = datetime.now() + timedelta(seconds=0.02)
        while datetime.now() < end: pass
        say()
    """)
    assert now == pytest.approx(0.02, abs=0.001)


CHANCE = """
    import os, random, secrets, uuid
    import numpy as np
    from rclpy_virtual_time.host import randomness
    randomness.seed({seed})
    say(random.random(), random.Random().random(), random.SystemRandom().random(),
        np.random.rand(), np.random.default_rng().random(), np.random.RandomState(3).rand(),
        str(uuid.uuid4()), secrets.token_hex(8), os.urandom(4).hex(), os.getrandom(4).hex())
"""


def test_chance_is_the_same_in_each_run_and_another_with_another_seed() -> None:
    first, again, other = (run(CHANCE.format(seed=seed)) for seed in (7, 7, 8))
    assert first == again
    same = [a == b for a, b in zip(first[0][1:], other[0][1:], strict=True)]
    assert same == [False] * 5 + [True] + [False] * 4  # RandomState(3) has its own seed


def test_the_second_ends_when_it_ends() -> None:
    said = run("""
        import datetime
        time.sleep(1 - 1e-5)
        say(time.localtime()[5] == datetime.datetime.now().second, time.gmtime().tm_sec % 60)
        time.sleep(1e-5)
        say(time.localtime()[5] == datetime.datetime.now().second, time.gmtime().tm_sec % 60)
    """)
    assert [same for _, same, _ in said] == [True, True]
    assert said[1][2] == (said[0][2] + 1) % 60  # type: ignore[operator]


# What a program does, and what it says and when.
PROGRAMS = {
    "nobody sets the clock of the machine": ("""
        for set_time in (time.clock_settime, time.clock_settime_ns):
            try: set_time(time.CLOCK_MONOTONIC, 0)  # which no kernel would allow either
            except OSError as error: say(type(error).__name__)
    """, [[0.0, "PermissionError"]] * 2),
    "an alarm interrupts whatever the main thread waits for": ("""
        import signal
        def ring(number, frame): say('ring', number == signal.SIGALRM)
        signal.signal(signal.SIGALRM, ring)
        signal.alarm(1)
        time.sleep(3.0); say('slept')
        signal.setitimer(signal.ITIMER_REAL, 0.5, 1.0)
        say(*signal.getitimer(signal.ITIMER_REAL))
        threading.Event().wait(2.0); say('waited')
        say(*signal.setitimer(signal.ITIMER_REAL, 0))
        time.sleep(4.0); say('quiet')
    """, [[1.0, "ring", True], [3.0, "slept"], [3.0, 0.5, 1.0], [3.5, "ring", True],
          [4.5, "ring", True], [5.0, "waited"], [5.0, 0.5, 1.0], [9.0, "quiet"]]),
    "an alarm that raises ends the wait": ("""
        import signal
        class Late(Exception): pass
        def ring(number, frame): raise Late
        signal.signal(signal.SIGALRM, ring)
        lock = threading.Lock(); lock.acquire()
        for wait in (lambda: time.sleep(9), lock.acquire, threading.Event().wait,
                     queue.Queue().get, threading.Barrier(2).wait):
            signal.setitimer(signal.ITIMER_REAL, 0.25)
            try: wait()
            except Late: say('late')
    """, [[0.25 * (i + 1), "late"] for i in range(5)]),
    "clocks that python does not name": ("""
        import os
        clocks = [lambda i=i: time.clock_gettime(i) for i in (5, 6, 8, 9)]
        clocks.append(lambda: os.times().elapsed)
        before = [clock() for clock in clocks]
        time.sleep(0.75)
        say(*(round(clock() - then, 3) for clock, then in zip(clocks, before)))
    """, [[0.75] + [0.75] * 5]),
    "sleep refuses what it cannot understand": ("""
        for bad in ('x', None, -0.5):
            try: time.sleep(bad)
            except (TypeError, ValueError) as error: say(f'{type(error).__name__}: {error}')
        time.sleep(True); say('slept')
    """, [[0.0, "TypeError: 'str' object cannot be interpreted as an integer"],
          [0.0, "TypeError: 'NoneType' object cannot be interpreted as an integer"],
          [0.0, "ValueError: sleep length must be non-negative"], [1.0, "slept"]]),
    "select as a sleep takes its time": ("""
        import select
        select.select([], [], [], 0.3); say()
        say(len(select.poll().poll(250)))
        say(len(select.epoll().poll(0.2)))
    """, [[0.3], [0.55, 0], [0.75, 0]]),
}  # fmt: skip


@pytest.mark.parametrize(("source", "said"), PROGRAMS.values(), ids=PROGRAMS)
def test_waits_and_clocks_are_those_of_virtual_time(source: str, said: list[object]) -> None:
    assert run(source) == said
