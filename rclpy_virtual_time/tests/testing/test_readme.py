"""The engine's README: its test passes, and a run may be put into virtual time as a whole."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from rclpy_virtual_time.tests.testing.outside import pytest_in, write

README = (Path(__file__).parents[2] / "README.md").read_text("utf-8")
(EXAMPLE,) = re.findall(r"(?ms)^```python\n(.*?)^```$", README)
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
# nobody wrote these for virtual time; an hour of it takes no hour
OTHERS = """
    import threading
    import time
    import unittest

    import rclpy
    from rclpy.executors import MultiThreadedExecutor, SingleThreadedExecutor
    from rclpy.task import Future
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
    """


def package_in(folder: Path) -> None:
    write(folder / "my_package", __init__="", talker=TALKER)
    (folder / "test_talker.py").write_text(EXAMPLE, "utf-8")


@pytest.mark.parametrize("options", [(), ("--virtual-time-portable",)], ids=["real", "portable"])
def test_the_first_screen(options: tuple[str, ...], tmp_path: Path) -> None:
    package_in(tmp_path / "run")
    session = pytest_in(tmp_path / "run", *options)
    assert session.code == 0, session.output
    assert list(session.tests) == ["test_talker.test_it_says_hello_twice_a_second"]


def test_a_slower_talker_fails_it(tmp_path: Path) -> None:
    package_in(tmp_path / "run")
    source = tmp_path / "run" / "my_package" / "talker.py"
    source.write_text(source.read_text("utf-8").replace("0.5", "0.6"), "utf-8")
    assert "assert 50 == 60" in pytest_in(tmp_path / "run").output


def test_a_run_of_others_tests(tmp_path: Path) -> None:
    write(tmp_path, test_others=OTHERS)
    session = pytest_in(tmp_path, "--virtual-time", "-o", "python_classes=Test")
    assert session.outcomes() == {
        "test_others.TestWaits.test_a_service": "passed",
        "test_others.TestWaits.test_nothing_comes": "passed",
    }, session.output
