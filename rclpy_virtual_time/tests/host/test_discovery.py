"""Ends find each other as on DDS: each program here was measured on plain rclpy, too."""

from collections.abc import Callable
from pathlib import Path
from textwrap import dedent

import pytest

from rclpy_virtual_time import Delivery, Discovery, ForkServer, Offer, ProgramStart
from rclpy_virtual_time.tests.runs import (
    LIDAR,
    MS,
    PREAMBLE,
    RunNode,
    end_of,
    run_beside_lidar,
    said,
    scans,
    sent,
)  # fmt: skip

HEAD = f"""{PREAMBLE}
from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.wait_for_message import wait_for_message
from std_srvs.srv import Trigger
from tf2_msgs.msg import TFMessage
LATCHED = QoSProfile(depth=2, durability=DurabilityPolicy.TRANSIENT_LOCAL)
def now(): return round(time.monotonic() - 1000, 4)
def tell(*words): print(*words, now())
def yes(request, response):
    response.success = True
    return response
rclpy.init()
"""
# What takes how long here, exactly [s]; each later end is found late.
EXACTLY = Discovery((100 * MS, 100 * MS), 1.0, (4 * MS, 4 * MS), (10 * MS, 10 * MS))
FRAMES = Offer("/tf_static", "tf2_msgs/msg/TFMessage", reliable=True, latched=True)
ONCE = (0, Delivery("/tf_static", b"\0\1\0\0" + bytes(4)))  # no transforms

Run = Callable[..., list[str]]


@pytest.fixture
def run(runtime: ForkServer, tmp_path: Path) -> Run:
    """Run programs that start at these times; return what they print."""

    def run_programs(*sources: str, starts: tuple[float, ...] = (), seconds: float) -> list[str]:
        programs = []
        for number, source in enumerate(sources):
            (tmp_path / f"program_{number}.py").write_text(HEAD + dedent(source), "utf-8")
            start = round((*starts, *[0.0] * len(sources))[number] * 1e9)
            programs.append(ProgramStart(f"program_{number}.py", start=start))
        recording = run_beside_lidar(
            runtime, tmp_path, *programs, seconds=seconds, discovery=EXACTLY,
            offers=[LIDAR, FRAMES], deliveries=[ONCE, *scans(round(seconds * 1e9))],
        )  # fmt: skip
        assert end_of(recording) == "completed", recording
        return said(recording)

    return run_programs


CONSTRUCTOR = f"""
{HEAD}
node = Node('node')
matched = PublisherEventCallbacks(matched=lambda info: tell('matched', info.current_count))
publishers = [
    node.create_publisher(Twist, '/cmd_vel', 10, event_callbacks=matched),
    node.create_publisher(String, '/plain', 10),
    node.create_publisher(String, '/latched', LATCHED),
]
node.create_subscription(String, '/plain', lambda m: tell('own', m.data), 10)
scans = node.create_subscription(LaserScan, '/scan', lambda m: None, 10)
def look():
    tell(publishers[0].get_subscription_count(), node.count_subscribers('/cmd_vel'),
         scans.get_publisher_count(), node.count_publishers('/scan'), node.get_node_names(),
         len(node.get_publishers_info_by_topic('/scan')))
def speak():
    for publisher in publishers:
        publisher.publish(publisher.msg_type())
look()
speak()
"""


def test_a_constructor_speaks_to_nobody_but_its_own_program(run_node: RunNode) -> None:
    recording = run_node(
        CONSTRUCTOR + "node.create_timer(0.05, look); rclpy.spin_once(node)\n"
        "for _ in range(3): rclpy.spin_once(node)\nsys.exit()"
    )

    assert said(recording) == [
        "0 0 0 0 ['node'] 0 -0.0001", "matched 1 -0.0001", "own  -0.0001",
        "1 1 1 1 ['node', 'mock_robot'] 1 0.05",
    ]  # fmt: skip
    assert [m.topic for m in recording.published] == ["/latched"]


WAITS = (
    "time.sleep(1.0)",
    "while not node.publisher.get_subscription_count(): time.sleep(0.01)",
    "rclpy.spin_once(node, timeout_sec=0.0)",
)


@pytest.mark.parametrize("wait", WAITS)
def test_who_waits_first_is_heard(run_node: RunNode, wait: str) -> None:
    recording = run_node(f"""
        rclpy.init(); node = Echo()
        {wait}
        node.publisher.publish(Twist())
        rclpy.spin(node)
    """)

    assert end_of(recording) == "completed", recording
    assert [m.time for m in recording.published][:2] == [0, 13 * MS]


def test_of_later_publishers_some_are_found_too_late(run_node: RunNode) -> None:
    recording = run_node(
        """
        class Making(Echo):
            def on_scan(self, scan):
                late = self.create_publisher(Twist, '/cmd_vel', 10)
                print(late.get_subscription_count())
                late.publish(Twist())
        rclpy.init(); rclpy.spin(Making())
        """,
        20.0,
    )

    heard = len(sent(recording, "/cmd_vel"))
    assert set(said(recording)) == {"1"}  # it has found the robot at once
    assert 160 < heard < 200  # of as many scans


TALKER = """
    node = Node('talker')
    talk = node.create_publisher(String, '/talk', 10)
    kept = node.create_publisher(String, '/kept', LATCHED)
    asks = node.create_client(Trigger, '/ask')
    def ask():
        answered = lambda _, at=now(): tell('answered', at)
        asks.call_async(Trigger.Request()).add_done_callback(answered)
    def on_timer():
        if now() < 0.45:
            talk.publish(String(data=str(now())))
            kept.publish(String(data=str(now())))
            ask()
        if now() in (0.2, 0.3, 0.4):
            tell(talk.get_subscription_count(), node.count_subscribers('/talk'),
                 node.count_services('/ask'), asks.service_is_ready(), node.get_node_names())
    node.create_timer(0.1, on_timer)
    rclpy.spin(node)
"""
LISTENER = """
    node = Node('listener')
    tell(node.get_node_names(), node.count_publishers('/talk'))
    matched = SubscriptionEventCallbacks(matched=lambda info: tell('matched', info.current_count))
    node.create_subscription(String, '/talk', lambda m: tell('heard', m.data), 10,
                             event_callbacks=matched)
    node.create_subscription(String, '/kept', lambda m: tell('kept', m.data), LATCHED)
    node.create_subscription(TFMessage, '/tf_static', lambda m, info: tell('tf'), LATCHED)
    node.create_subscription(LaserScan, '/scan', lambda m: tell('scan'), 10)
    node.create_service(Trigger, '/ask', yes)
    rclpy.spin(node)
"""


def test_a_program_that_comes_later_is_found_later(run: Run) -> None:
    assert run(TALKER, LISTENER, starts=(0.0, 0.25), seconds=0.55) == [
        "0 0 0 False ['talker', 'mock_robot'] 0.2", "['listener'] 0 0.25",
        "0 0 0 False ['talker', 'mock_robot'] 0.3",
        "matched 1 0.35", "kept 0.2 0.35", "kept 0.3 0.35", "tf 0.35",
        "1 1 1 True ['talker', 'mock_robot', 'listener'] 0.4",
        "heard 0.4 0.4", "kept 0.4 0.4", "answered 0.4 0.4", "scan 0.413", "scan 0.513",
    ]  # fmt: skip


CLIENT = """
    node = Node('client')
    client = node.create_client(Trigger, '/ask')
    for _ in range(2):
        future = client.call_async(Trigger.Request())
        rclpy.spin_until_future_complete(node, future, timeout_sec=0.3)
        tell('answered', future.done())
    tell(client.wait_for_service())
"""


def test_a_request_is_lost_before_the_server_is_found(run: Run) -> None:
    server = "node = Node('server'); node.create_service(Trigger, '/ask', yes); rclpy.spin(node)"
    told = run(server, CLIENT + "    rclpy.spin(node)", seconds=0.5)
    assert told == ["answered False 0.3", "answered True 0.3", "True 0.3"]


def test_a_server_that_rclpy_makes_in_c_is_found_in_its_own_program(run: Run) -> None:
    """A lifecycle node's, which no `create_service` has made."""
    program = """
        from lifecycle_msgs.srv import GetState
        from rclpy.lifecycle import LifecycleNode
        managed, node = LifecycleNode('managed'), Node('manager')
        executor = rclpy.executors.SingleThreadedExecutor()
        executor.add_node(managed)
        executor.add_node(node)
        client = node.create_client(GetState, '/managed/get_state')
        future = client.call_async(GetState.Request())
        executor.spin_until_future_complete(future, timeout_sec=0.3)
        tell(future.result() and future.result().current_state.label)
        executor.spin()
    """
    (told,) = run(program, seconds=0.5)
    assert told.startswith("unconfigured ")  # None where the request is lost


def test_what_is_made_later_is_found_by_others_late(run: Run) -> None:
    making = """
        node = Node('making')
        def make():
            timer.cancel()
            node.create_service(Trigger, '/ask', yes)
            node.create_subscription(String, '/own', lambda m: tell('own'), 10)
            node.create_publisher(String, '/own', 10).publish(String())
            node.create_publisher(String, '/talk', 10).publish(String(data='lost'))
            for _ in range(2):
                node.create_subscription(TFMessage, '/tf_static', lambda m: tell('tf'), LATCHED)
        timer = node.create_timer(0.1, make)
        rclpy.spin(node)
    """
    watching = """
        node = Node('watching')
        talk = node.create_subscription(String, '/talk', lambda m: tell(m.data), 10)
        client = node.create_client(Trigger, '/ask')
        def look():
            if 0.1005 < now() < 0.1055:
                tell(client.service_is_ready(), talk.get_publisher_count())
        node.create_timer(0.001, look)
        rclpy.spin(node)
    """
    assert run(making, watching, seconds=0.3) == [
        "own 0.1", "False 0 0.101", "False 0 0.102", "False 0 0.103", "True 1 0.104",
        "True 1 0.105", "tf 0.11", "tf 0.11",
    ]  # fmt: skip
