"""Tests in virtual time: the fixture, its world, and how such a test can end.

rclpy_virtual_time/testing/virtual_time.py and host/testing (alone, session, world) are tested here.
"""

from pathlib import Path

import pytest
from outside import Session, pytest_in, write

NODES = """
    from rclpy.node import Node
    from std_msgs.msg import String

    class Ticker(Node):
        '''Says "1", "2" … on /tick, twice a second, and hears /in.'''

        def __init__(self):
            super().__init__("ticker")
            self.heard = []
            self.publisher = self.create_publisher(String, "/tick", 10)
            self.create_timer(0.5, self.tick)
            self.create_subscription(String, "/in", self.on_in, 10)
            self.count = 0

        def tick(self):
            self.count += 1
            self.publisher.publish(String(data=str(self.count)))

        def on_in(self, message):
            now = self.get_clock().now().nanoseconds
            self.heard.append((now % 10**11 / 1e9, message.data))
    """
CONFTEST = """
    import pytest

    ENTERED = []

    @pytest.fixture(scope="module")
    def of_the_module():
        ENTERED.append("module")
        yield ENTERED
    """
RIGHT = """
    import asyncio
    import os
    import queue
    import random
    import threading
    import time
    import pytest
    import rclpy
    from nodes import Ticker
    from rclpy.executors import MultiThreadedExecutor
    from std_msgs.msg import String

    def test_before(of_the_module):
        assert of_the_module == ["module"]

    def test_world(virtual_time):
        with virtual_time() as world:
            heard = world.listen("/tick", String)
            for k in range(3):
                message = String(data=f"in {k}")
                world.publish("/in", message, at=0.25 + k)
                message.data = "changed after it was sent"
            ticker = Ticker()
            assert sorted(ticker.get_node_names()) == ["test", "ticker"]
            world.run(ticker, until=2.0)
            assert (world.now, ticker.count) == (2.0, 4)  # all that is due at the end is done
            assert (world.stamp().nanosec, world.stamp(2.25).nanosec) == (0, 250_000_000)
            assert heard.times == [0.5, 1.0, 1.5, 2.0]
            assert [message.data for message in heard] == ["1", "2", "3", "4"]
            assert ticker.heard == [(0.25, "in 0"), (1.25, "in 1")]
            world.publish("/in", String(data="now"))
            world.run(ticker, until=3.0)
        assert [said for _, said in ticker.heard] == ["in 0", "in 1", "now", "in 2"]
        assert len(heard) == 6 and heard[-1].data == "6"

    @pytest.mark.virtual_time
    def test_the_mark_is_enough():
        began = time.monotonic()
        asyncio.run(asyncio.sleep(7.0))
        threading.Event().wait(3.0)
        assert 10.0 <= time.monotonic() - began < 10.1  # a loop that begins or ends looks around

    def test_blocks_one_after_another(virtual_time):
        for _ in range(2):
            with virtual_time(args=["--ros-args", "-p", "speed:=0.5"]) as world:
                ticker = Ticker()
                assert ticker.declare_parameter("speed", 0.1).value == 0.5
                world.run(ticker, until=1.0)
                assert (world.now, ticker.count) == (1.0, 2)
            assert not rclpy.ok()

    class TestInAClass:
        @pytest.mark.parametrize("text", ["a b", "c::d", "e/f"])
        def test_with_fixtures(self, virtual_time, of_the_module, text, tmp_path, monkeypatch):
            monkeypatch.setenv("HERE", text)
            (tmp_path / "file").write_text(text)
            assert os.environ["HERE"] == (tmp_path / "file").read_text()
            assert of_the_module == ["module"]
            assert os.environ["OF_THE_STUDENT"] == "yes"

    @pytest.mark.xfail(strict=True)
    def test_expected_to_fail(virtual_time):
        assert False

    def test_the_same_in_every_run(virtual_time, record_property):
        said, jobs = [], queue.Queue()

        def work(name):
            for _ in range(5):
                time.sleep(random.random())
                jobs.put((name, round(time.monotonic(), 9)))

        with virtual_time() as world:
            heard = world.listen("/tick", String)
            threads = [threading.Thread(target=work, args=(k,)) for k in range(10)]
            for thread in threads:
                thread.start()
            world.run(Ticker(), until=4.0, executor=MultiThreadedExecutor(4))
            for thread in threads:
                thread.join()
        while not jobs.empty():
            said.append(jobs.get())
        assert len(said) == 50 and len({name for name, _ in said[:10]}) > 5
        record_property("said", f"{said} {heard.times} {random.random()} {os.urandom(4).hex()}")

    def test_after(of_the_module):
        assert of_the_module == ["module"] and time.time() > 1.75e9
    """
WRONG = """
    import os
    import threading
    import time
    import warnings
    import pytest
    import rclpy
    from nodes import Ticker
    from rclpy.experimental.events_executor import EventsExecutor
    from std_msgs.msg import String

    def test_assertion(virtual_time):
        with virtual_time() as world:
            ticker = Ticker()
            world.run(ticker, until=2.0)
            print("counted", ticker.count)
            warnings.simplefilter("default")
            warnings.warn("worn out")
            assert ticker.count == 5

    def test_callback(virtual_time):
        with virtual_time() as world:
            ticker = Ticker()
            ticker.create_timer(0.1, lambda: 1 / 0)
            world.run(ticker, until=2.0)

    def test_never_ends(virtual_time):
        with virtual_time():
            rclpy.spin(Ticker())

    def test_deadlock(virtual_time):
        time.sleep(3.0)
        lock = threading.Lock()
        with lock:
            lock.acquire()

    @pytest.mark.virtual_time(patience=5.0)
    def test_computes_for_ever():
        while True:
            pass

    def test_dies(virtual_time): os._exit(3)

    def test_too_late(virtual_time):
        with virtual_time() as world:
            world.run(until=1.0)
            world.publish("/in", String(), at=0.5)

    def test_goes_back(virtual_time):
        with virtual_time() as world:
            world.run(until=1.0)
            world.run(until=0.5)

    def test_with_drive(virtual_time, drive): pass

    @pytest.mark.virtual_time(limit=-1)
    def test_no_limit(): pass

    @pytest.mark.virtual_time(limi=5)
    def test_no_such_limit(): pass

    def test_interrupted(virtual_time): raise KeyboardInterrupt

    def test_events(virtual_time):
        with virtual_time():
            EventsExecutor()

    def test_teardown(virtual_time, request): request.addfinalizer(lambda: 1 / 0)
    """
DAILY = """
    import subprocess
    import threading
    import time

    import rclpy
    from nodes import Ticker
    from our_types.srv import Ask  # of text, in a folder beside the package's
    from rclpy.executors import MultiThreadedExecutor
    from std_msgs.msg import String
    from std_srvs.srv import Trigger

    def test_waiting_takes_virtual_time(virtual_time):
        with virtual_time() as world:
            time.sleep(50.0)
            assert world.now == 50.0
            ticker = Ticker()
            ticker.create_timer(0.5, lambda: time.sleep(0.7))  # never done
            world.run(ticker, until=53.0)
            assert 53.0 <= world.now < 54.0
            with subprocess.Popen(["sleep", "0.2"]) as other:  # in real time
                assert other.wait(timeout=300) == 0

    def test_a_type_of_our_own(virtual_time):
        with virtual_time() as world:
            ticker = Ticker()
            ticker.create_service(Ask, "/ask", lambda _, answer: Ask.Response(near=True))
            asked = ticker.create_client(Ask, "/ask").call_async(Ask.Request())
            world.run(ticker, until=1.0)
            assert asked.result().near

    def test_timers_and_subscriptions(virtual_time):
        with virtual_time() as world:
            heard, ticker = world.listen("/tick", String), Ticker()
            world.run(ticker, until=0.4)  # what comes after silence is heard, too
            for text in ("now", "now, too"):
                world.publish("/in", String(data=text))
            world.publish("/in", String(data="later"), at=1.25)
            world.run(ticker, until=1.5, executor=MultiThreadedExecutor(2))
            threading.Thread(target=rclpy.spin, args=(ticker,), daemon=True).start()
            world.run(until=2.0)
            assert heard.times == [0.5, 1.0, 1.5, 2.0]
            heard = [(round(at, 3), text) for at, text in ticker.heard]
            assert heard == [(0.4, "now"), (0.4, "now, too"), (1.25, "later")]

    def test_a_node_beside_another_and_a_service(virtual_time):
        with virtual_time() as world:
            ticker, other, heard = Ticker(), rclpy.create_node("other"), []
            ticker.create_service(Trigger, "/count", lambda _, answer: count(ticker, answer))
            client, futures = other.create_client(Trigger, "/count"), []
            other.create_subscription(String, "/tick", lambda m: heard.append(m.data), 10)
            other.create_timer(0.7, lambda: futures.append(client.call_async(Trigger.Request())))
            world.run(ticker, other, until=2.2)
            assert heard == ["1", "2", "3", "4"]
            assert [future.result().message for future in futures] == ["1", "2", "4"]

    def count(ticker, answer):
        answer.message = str(ticker.count)
        return answer
    """
SAID = {
    "assertion": "assert 4 == 5",
    "callback": "ZeroDivisionError",
    "never_ends": "Failed: the test still runs after 60 s of virtual time, its limit",
    "deadlock": "Failed: nothing can happen any more since 3 s: every thread waits",
    "computes_for_ever": "the test still runs after 5 s of real time: it computes, or waits in",
    "dies": "the test's process ended by itself (exit code 3)",
    "too_late": "ValueError: publish(at=0.5): it is 1 s already",
    "goes_back": "ValueError: run(until=0.5): it is 1 s already",
    "with_drive": "drive has a time of its own: use it without virtual_time",
    "no_limit": "virtual_time: @pytest.mark.virtual_time(limit=-1): expected seconds",
    "no_such_limit": "got an unexpected keyword argument 'limi'",
    "interrupted": "pytest ended in the test's own process, but the test did not",
    "events": "EventsExecutor waits for DDS in native code, where virtual time does not reach",
    "teardown": "ZeroDivisionError",
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("student").resolve()
    write(folder, nodes=NODES, conftest=CONFTEST, test_right=RIGHT, test_wrong=WRONG)
    return folder


@pytest.mark.long
def test_right_tests_pass_and_repeat(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("OF_THE_STUDENT", "yes")
    first, second = (pytest_in(folder, "test_right.py") for _ in range(2))
    assert first.code == 0, first.output
    others = {name: how for name, how in first.outcomes().items() if how != "passed"}
    assert others == {"test_right.test_expected_to_fail": "skipped"}
    assert len(first.tests) == RIGHT.count("def test_") + 2
    said, again = (
        session.tests["test_right.test_the_same_in_every_run"].properties["said"]
        for session in (first, second)
    )
    assert len(said) > 500
    assert said == again


@pytest.fixture(scope="module")
def wrong(folder: Path) -> Session:
    return pytest_in(folder, "test_wrong.py")


@pytest.mark.long
@pytest.mark.parametrize("name", SAID)
def test_what_is_wrong_is_said(wrong: Session, name: str) -> None:
    result = wrong.tests[f"test_wrong.test_{name}"]
    assert result.outcome in ("failed", "error"), wrong.output
    assert SAID[name] in result.text
    assert "rclpy_virtual_time/host" not in result.text


@pytest.mark.long
def test_what_was_printed_and_the_line_that_waits_are_shown(wrong: Session) -> None:
    assert len(wrong.tests) == len(SAID)
    assert "counted 4" in wrong.output and "UserWarning: worn out" in wrong.output
    assert ">           lock.acquire()" in wrong.tests["test_wrong.test_deadlock"].text
    assert "in test_computes_for_ever" in wrong.tests["test_wrong.test_computes_for_ever"].text


@pytest.mark.long
def test_a_file_that_only_breaks_in_the_other_process(tmp_path: Path) -> None:
    lines = [
        "import os, sys",
        "if 'rclpy_virtual_time.host.program' in sys.modules: raise OSError('not here')",
    ]
    write(tmp_path, test_it="\n".join([*lines, "def test_it(virtual_time): pass"]))
    session = pytest_in(tmp_path)
    assert session.outcomes() == {"test_it.test_it": "failed"}
    assert "OSError: not here" in session.tests["test_it.test_it"].text


def test_what_people_test_daily(tmp_path: Path) -> None:
    """The one of this page that `make test` runs besides."""
    (tmp_path / "our_types" / "srv").mkdir(parents=True)
    (tmp_path / "our_types" / "srv" / "Ask.srv").write_text("---\nbool near")
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "package.xml").touch()
    (tmp_path / "mine" / "pytest.ini").touch()
    write(tmp_path / "mine", nodes=NODES, test_daily=DAILY)
    session = pytest_in(tmp_path / "mine")
    assert session.code == 0, session.output
    assert len(session.tests) == DAILY.count("def test_")
