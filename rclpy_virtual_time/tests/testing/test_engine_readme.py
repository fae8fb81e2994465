"""The engine's README: its test passes, and a run may be put into virtual time as a whole."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

from rclpy_virtual_time.link.hosts import ROOT
from rclpy_virtual_time.tests.testing.outside import pytest_in, write

README = (Path(__file__).parents[2] / "README.md").read_text("utf-8")
EXAMPLE, RUNS_PROGRAMS = re.findall(r"(?ms)^```python\n(.*?)^```$", README)
TALKER = """
    import rclpy
    from rclpy.node import Node
    from std_msgs.msg import String

    class Talker(Node):
        def __init__(self):
            super().__init__("talker")
            self.publisher = self.create_publisher(String, "/chatter", 10)
            self.create_timer(0.5, lambda: self.publisher.publish(String(data="hello")))
    """
# of each kind of node one
KINDS = """
    import threading
    import time

    import pytest
    import rclpy
    from rclpy.action import ActionClient, ActionServer
    from rclpy.callback_groups import ReentrantCallbackGroup
    from rclpy.executors import MultiThreadedExecutor
    from std_msgs.msg import String
    from std_srvs.srv import Trigger

    def test_publisher_and_subscriber(virtual_time):
        with virtual_time() as world:
            talker, listener = rclpy.create_node("talker"), rclpy.create_node("listener")
            publisher, heard = talker.create_publisher(String, "topic", 10), []
            talker.create_timer(0.5, lambda: publisher.publish(String(data="Hello World")))
            listener.create_subscription(String, "topic", lambda m: heard.append(m.data), 10)
            world.run(talker, listener, until=10.0)
        assert heard == ["Hello World"] * 20

    def test_several_threads(virtual_time):
        with virtual_time() as world:
            node, ended = rclpy.create_node("slow"), []
            group = ReentrantCallbackGroup()

            def work():
                time.sleep(2.5)
                ended.append((round(world.now, 3), threading.current_thread().name))

            node.create_timer(1.0, work, callback_group=group)
            world.run(node, until=6.0, executor=MultiThreadedExecutor(num_threads=4))
        assert [at for at, _ in ended][:3] == [3.5, 4.5, 5.5]
        assert len({name for _, name in ended}) > 1

    def test_service(virtual_time):
        with virtual_time():
            server, client_node = rclpy.create_node("server"), rclpy.create_node("client")

            def answer(request, response):
                time.sleep(20.0)
                response.message = "done"
                return response

            server.create_service(Trigger, "work", answer)
            threading.Thread(target=rclpy.spin, args=(server,), daemon=True).start()
            client = client_node.create_client(Trigger, "work")
            assert client.wait_for_service(timeout_sec=1.0)
            future, began = client.call_async(Trigger.Request()), time.monotonic()
            rclpy.spin_until_future_complete(client_node, future)
            assert future.result().message == "done"
            assert 20.0 <= time.monotonic() - began < 20.1

    def test_action(virtual_time):
        Fibonacci = pytest.importorskip("test_msgs.action").Fibonacci

        with virtual_time():
            server_node, node = rclpy.create_node("server"), rclpy.create_node("client")

            def execute(goal):
                time.sleep(30.0)
                goal.succeed()
                return Fibonacci.Result(sequence=list(range(goal.request.order)))

            server = ActionServer(server_node, Fibonacci, "count", execute)
            threading.Thread(target=rclpy.spin, args=(server_node,), daemon=True).start()
            client = ActionClient(node, Fibonacci, "count")
            assert client.wait_for_server(timeout_sec=1.0)
            sent = client.send_goal_async(Fibonacci.Goal(order=3))
            rclpy.spin_until_future_complete(node, sent)
            future = sent.result().get_result_async()
            rclpy.spin_until_future_complete(node, future)
            assert list(future.result().result.sequence) == [0, 1, 2]
    """
# nobody wrote these for virtual time; an hour of it takes no hour
OTHERS = """
    import threading
    import time
    import unittest

    import rclpy
    from rclpy.executors import MultiThreadedExecutor, SingleThreadedExecutor
    from rclpy.qos import DurabilityPolicy, QoSProfile
    from rclpy.task import Future
    from std_msgs.msg import String
    from std_srvs.srv import Trigger

    class TestWaits(unittest.TestCase):
        @classmethod
        def setUpClass(cls):
            rclpy.init()

        @classmethod
        def tearDownClass(cls):
            rclpy.shutdown()

        def test_a_service(self):
            node, client_node = rclpy.create_node("server"), rclpy.create_node("client")
            service = node.create_service(Trigger, "/go", self.answer)
            executor = MultiThreadedExecutor()
            executor.add_node(node)
            threading.Thread(target=executor.spin, daemon=True).start()
            client = client_node.create_client(Trigger, "/go")
            assert client.wait_for_service(timeout_sec=5.0)
            future = client.call_async(Trigger.Request())
            rclpy.spin_until_future_complete(client_node, future, timeout_sec=2000.0)
            assert future.result().message == "done"
            executor.shutdown()

        def answer(self, request, response):
            time.sleep(1800.0)
            response.message = "done"
            return response

        def test_nothing_comes(self):
            node, executor = rclpy.create_node("waits"), SingleThreadedExecutor()
            executor.add_node(node)
            began = time.time()
            executor.spin_until_future_complete(Future(), timeout_sec=1800.0)
            assert 1800.0 <= time.time() - began < 1801.0

        def test_an_executor_that_is_shut_down(self):
            executor, over = SingleThreadedExecutor(), threading.Event()

            def spin():
                while not over.is_set():
                    executor.spin_once(timeout_sec=0.1)

            thread = threading.Thread(target=spin)
            thread.start()
            executor.shutdown()
            time.sleep(1.0)  # beside a loop that never waits again
            over.set()
            thread.join()

        def test_an_answer_below_rclpy(self):
            node, asked = rclpy.create_node("server"), []
            service = node.create_service(Trigger, "/go", lambda _, response: response)
            service.send_response = lambda _, header: asked.append(header)
            future = node.create_client(Trigger, "/go").call_async(Trigger.Request())
            while not asked:
                rclpy.spin_once(node, timeout_sec=1.0)
            rclpy.spin_once(node, timeout_sec=1.0)
            with service.handle:
                answer = Trigger.Response(message="late")
                service.handle.service_send_response(answer, asked[0].request_id)
            rclpy.spin_until_future_complete(node, future, timeout_sec=1.0)
            assert future.result().message == "late"

        def test_what_was_latched(self):
            node, heard = rclpy.create_node("late"), []
            qos = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
            publisher = node.create_publisher(String, "/latched", qos)
            publisher.publish(String(data="before"))
            node.create_subscription(String, "/latched", heard.append, qos)
            rclpy.spin_once(node, timeout_sec=0)
            assert heard
    """


def package_in(folder: Path) -> None:
    write(folder / "my_package", __init__="", talker=TALKER)
    write(folder, test_kinds=KINDS)
    (folder / "test_talker.py").write_text(EXAMPLE, "utf-8")


@pytest.mark.parametrize(
    "options",
    [(), pytest.param(("--virtual-time-portable",), marks=pytest.mark.long)],
    ids=["real", "portable"],
)
def test_the_first_screen(options: tuple[str, ...], tmp_path: Path) -> None:
    package_in(tmp_path / "run")
    session = pytest_in(tmp_path / "run", *options)
    assert session.code == 0, session.output
    said = session.outcomes()
    assert said.pop("test_kinds.test_action") in ("passed", "skipped")  # without test_msgs
    assert len(said) == 4 and set(said.values()) == {"passed"}


@pytest.mark.long
def test_a_slower_talker_fails_it(tmp_path: Path) -> None:
    package_in(tmp_path / "run")
    source = tmp_path / "run" / "my_package" / "talker.py"
    source.write_text(source.read_text("utf-8").replace("0.5", "0.6"), "utf-8")
    assert "assert 50 == 60" in pytest_in(tmp_path / "run").output


def test_a_run_of_others_tests(tmp_path: Path) -> None:
    write(tmp_path, test_others=OTHERS)
    session = pytest_in(tmp_path, "--virtual-time", "-o", "python_classes=Test")
    assert set(session.outcomes().values()) == {"passed"}, session.output
    assert len(session.tests) == OTHERS.count("def test_")


def test_programs_as_programs(tmp_path: Path) -> None:
    main = "    rclpy.init()\n    rclpy.spin(Talker())\n"
    write(tmp_path / "programs", talker=TALKER + main)
    done = subprocess.run(
        [sys.executable, "-c", RUNS_PROGRAMS],
        cwd=tmp_path, env={"PYTHONPATH": str(ROOT)}, capture_output=True, text=True, check=False,
    )  # fmt: skip
    said = [line.split(" ")[:3] for line in done.stdout.splitlines()]
    ends = [[time, topic, "std_msgs/msg/String"] for time in ("0.5", "29.5")
            for topic in ("/chatter", "/other")]  # fmt: skip
    assert (len(said), sorted(said[:2] + said[-2:])) == (118, sorted(ends)), done.stderr
