"""Executors build a wait set only where something may be ready, and then miss nothing."""

import pytest

from rclpy_virtual_time.tests.runs import RunNode, end_of, scans

MORE = """
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_srvs.srv import Trigger
"""
COUNTED = """
import rclpy.executors
native, made = rclpy.executors._rclpy, []
real = native.WaitSet
native.WaitSet = lambda *counts: made.append(counts) or real(*counts)

class Counting(Echo):
    def __init__(self):
        super().__init__()
        BESIDES
    def on_scan(self, scan):
        print(len(made), len(self.executor._tasks))
        super().on_scan(scan)
rclpy.init(); rclpy.spin(Counting())
"""
LATCHED = "QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)"
BESIDES = {  # what has no work when a scan comes
    "nothing": "pass",
    "a latched topic": f"self.create_subscription(String, 'map', print, {LATCHED})",
    "a timer": "self.create_timer(0.25, lambda: None)",
    "a latched topic that has been heard": f"""
        self.map = self.create_publisher(String, 'map', {LATCHED})
        self.map.publish(String())
        self.create_subscription(String, 'map', lambda _: None, {LATCHED})""",
}
TURNS = """
class Turns(Echo):
    def __init__(self):
        super().__init__()
        for name in 'ba':
            self.create_subscription(String, name, lambda _, name=name: print(name), 10)
        self.a, self.b = (self.create_publisher(String, name, 10) for name in 'ab')
        self.timer = self.create_timer(10.0, lambda: (print('timer'), self.timer.cancel()))
        self.asks = self.create_client(Trigger, 'ask')
        self.create_service(Trigger, 'ask', self.on_ask)
    def on_ask(self, request, response):
        print('asked')
        return response
    def on_scan(self, scan):
        if self.timer.timer_period_ns == 1:
            return
        self.asks.call_async(Trigger.Request()).add_done_callback(lambda _: print('answered'))
        for end in (self.a, self.a, self.b):
            end.publish(String())
        self.timer.timer_period_ns = 1
        self.timer.reset()
        time.sleep(0.01)
rclpy.init(); executor = EXECUTOR; executor.add_node(Turns()); executor.spin()
"""
LATER = """
class Later(SingleThreadedExecutor):
    def _spin_once_impl(self, timeout_sec=None, wait_condition=lambda: False):
        handler, _, _ = self.wait_for_ready_callbacks(timeout_sec, None, wait_condition)
        time.sleep(0.25)
        handler()
class Newest(Node):
    def __init__(self):
        super().__init__('newest')
        self.create_subscription(LaserScan, '/scan', self.on_scan, 1)
    def on_scan(self, scan):
        stamp = rclpy.time.Time.from_msg(scan.header.stamp)
        print((self.get_clock().now() - stamp).nanoseconds / 1e9)
rclpy.init(); executor = Later(); executor.add_node(Newest()); executor.spin()
"""
DONE = """
from rclpy.task import Future
rclpy.init(); node = Node('waits')
for _ in range(3):
    future, begin = Future(), time.monotonic()
    threading.Thread(target=lambda: (time.sleep(0.1), future.set_result(1))).start()
    rclpy.spin_until_future_complete(node, future)
    print(time.monotonic() - begin)
rclpy.spin(node)
"""
# Each prints "came" for what is sent in another way, while its end has been found empty.
WAYS = {
    "an answer of a service in C": """
        from lifecycle_msgs.srv import GetState
        from rclpy.lifecycle import LifecycleNode
        class Asking(Echo):
            def on_scan(self, scan):
                future = self.create_client(GetState, '/cycle/get_state').call_async(
                    GetState.Request())
                future.add_done_callback(lambda done: print('came'))
        rclpy.init(); other = SingleThreadedExecutor(); other.add_node(LifecycleNode('cycle'))
        threading.Thread(target=other.spin, daemon=True).start()
        rclpy.spin(Asking())
    """,
    "an event of a lifecycle node": """
        from lifecycle_msgs.msg import TransitionEvent
        from rclpy.lifecycle import LifecycleNode
        class Watching(Echo):
            def __init__(self):
                super().__init__()
                self.cycle, self.scans = LifecycleNode('cycle'), 0
                self.create_subscription(
                    TransitionEvent, '/cycle/transition_event', lambda event: print('came'), 10)
            def on_scan(self, scan):
                self.scans += 1
                if self.scans == 5:
                    self.cycle.trigger_configure()
        rclpy.init(); rclpy.spin(Watching())
    """,
    "three messages at once": """
        class Talking(Echo):
            def __init__(self):
                super().__init__()
                self.talk, self.heard = self.create_publisher(String, 'talk', 10), 0
                self.create_subscription(String, 'talk', self.on_talk, 10)
            def on_talk(self, said):
                self.heard += 1
                if self.heard % 3 == 0:
                    print('came')
            def on_scan(self, scan):
                for _ in range(3):
                    self.talk.publish(String())
        rclpy.init(); rclpy.spin(Talking())
    """,
    "a timer, a guard condition and what was taken by hand": """
        class Mixed(Echo):
            def __init__(self):
                super().__init__()
                self.guard = self.create_guard_condition(lambda: self.talk.publish(String()))
                self.talk = self.create_publisher(String, 'talk', 10)
                self.listener = self.create_subscription(String, 'talk', self.on_talk, 10)
                self.create_timer(0.25, self.guard.trigger)
            def on_talk(self, said):
                print('came')
            def on_scan(self, scan):
                self.talk.publish(String())
                with self.listener.handle:
                    self.listener.handle.take_message(String, False)
        rclpy.init(); rclpy.spin(Mixed())
    """,
}


@pytest.mark.parametrize("besides", BESIDES)
def test_a_message_that_comes_alone_costs_no_wait_set(besides: str, run_node: RunNode) -> None:
    recording = run_node(MORE + COUNTED.replace("BESIDES", BESIDES[besides].strip()), 2.0)
    counts, tasks = zip(*(map(int, line.text.split()) for line in recording.log), strict=True)
    assert len(counts) == len(list(scans(2 * 10**9))) > 15
    assert counts[-1] == counts[5]
    assert set(tasks[5:]) == {1}


@pytest.mark.parametrize("executor", ["SingleThreadedExecutor()", "MultiThreadedExecutor(2)"])
def test_what_one_look_has_found_comes_in_the_order_of_rclpy(
    executor: str, run_node: RunNode
) -> None:
    recording = run_node(MORE + TURNS.replace("EXECUTOR", executor), 1.0)
    assert [line.text for line in recording.log] == ["timer", "b", "a", "asked", "a", "answered"]


def test_an_executor_that_waits_before_a_callback_takes_the_newest(run_node: RunNode) -> None:
    ages = [float(line.text) for line in run_node(LATER, 2.0).log]
    assert len(ages) >= 3
    assert max(ages) < 0.1  # the lidar's period


def test_who_waits_for_a_future_goes_on_at_once(run_node: RunNode) -> None:
    waited = [float(line.text) for line in run_node(DONE, 1.0).log]
    assert len(waited) == 3
    assert max(waited) < 0.101


@pytest.mark.parametrize("way", WAYS)
def test_nothing_is_missed(way: str, run_node: RunNode) -> None:
    recording = run_node(WAYS[way], 1.0)
    assert end_of(recording) == "completed", recording
    assert [line.text for line in recording.log].count("came") >= (1 if "event" in way else 3)
