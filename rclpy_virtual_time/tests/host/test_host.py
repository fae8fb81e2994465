"""The host: students' programs on the real rclpy, in virtual time."""

import numpy as np
import pytest

from rclpy_virtual_time.tests.runs import RunNode, end_of, said, scans, sent, times

SPINNING = {
    "rclpy.spin": "rclpy.init(); rclpy.spin(Echo())",
    "spin_once": """
        rclpy.init(); node = Echo()
        while rclpy.ok():
            rclpy.spin_once(node)
    """,
    "spin_once with a timeout": """
        rclpy.init(); node = Echo()
        while rclpy.ok():
            rclpy.spin_once(node, timeout_sec=0.03)
    """,
    "spin_once without waiting": """
        rclpy.init(); node = Echo()
        while rclpy.ok():
            rclpy.spin_once(node, timeout_sec=0)
    """,
    "MultiThreadedExecutor": """
        rclpy.init(); executor = MultiThreadedExecutor(); executor.add_node(Echo()); executor.spin()
    """,
    "spin_until_future_complete": """
        rclpy.init(); node = Echo()
        rclpy.spin_until_future_complete(node, rclpy.task.Future())
    """,
    "spin in a thread": """
        rclpy.init(); node = Echo()
        threading.Thread(target=rclpy.spin, args=(node,)).start()
    """,
    "spin in a daemon thread, rate in main": """
        rclpy.init(); node = Echo()
        threading.Thread(target=rclpy.spin, args=(node,), daemon=True).start()
        rate = node.create_rate(10)
        while rclpy.ok():
            rate.sleep()
    """,
    "worker thread and queue": """
        import queue
        class Worker(Echo):
            def __init__(self):
                super().__init__()
                self.queue = queue.Queue()
                threading.Thread(target=self.work, daemon=True).start()
            def on_scan(self, scan):
                self.queue.put(scan)
            def work(self):
                while True:
                    self.queue.get()
                    self.publisher.publish(Twist())
        rclpy.init(); rclpy.spin(Worker())
    """,
    "condition variable": """
        class Worker(Echo):
            def __init__(self):
                super().__init__()
                self.fresh, self.condition = 0, threading.Condition()
                threading.Thread(target=self.work, daemon=True).start()
            def on_scan(self, scan):
                with self.condition:
                    self.fresh += 1
                    self.condition.notify()
            def work(self):
                while True:
                    with self.condition:
                        while not self.fresh:
                            self.condition.wait(timeout=0.7)
                        self.fresh -= 1
                    self.publisher.publish(Twist())
        rclpy.init(); rclpy.spin(Worker())
    """,
    "ThreadPoolExecutor": """
        from concurrent.futures import ThreadPoolExecutor
        class Pooled(Echo):
            pool = ThreadPoolExecutor(2)
            def on_scan(self, scan):
                self.pool.submit(self.publisher.publish, Twist())
        rclpy.init(); rclpy.spin(Pooled())
    """,
    "coroutine callback": """
        class Coroutine(Echo):
            async def on_scan(self, scan):
                self.publisher.publish(Twist())
        rclpy.init(); rclpy.spin(Coroutine())
    """,
}


@pytest.mark.parametrize("style", SPINNING)
def test_every_way_of_spinning_answers_every_scan(style: str, run_node: RunNode) -> None:
    recording = run_node(SPINNING[style])

    assert end_of(recording) == "completed", recording
    scanned = np.array([time for time, _ in scans(2 * 10**9)]) / 1e9
    assert len(scanned) == 20
    assert len(times(recording, "/cmd_vel")) == 20
    delay = times(recording, "/cmd_vel") - scanned
    assert delay.min() >= 0
    assert delay.max() <= 0.011


SLEEPY = """
    class Sleepy(Node):
        def __init__(self, *groups):
            super().__init__('sleepy')
            group = lambda: MutuallyExclusiveCallbackGroup() if groups else None
            self.publisher = self.create_publisher(Twist, 'cmd_vel', 10)
            self.create_subscription(LaserScan, 'scan', self.on_scan, 1, callback_group=group())
            self.create_timer(0.05, self.on_timer, callback_group=group())
        def on_scan(self, scan):
            start = time.perf_counter()
            time.sleep(0.2)
            print(time.perf_counter() - start)
        def on_timer(self):
            self.publisher.publish(Twist())
    rclpy.init()
"""


GROUPS = "executor = MultiThreadedExecutor(); executor.add_node(Sleepy('groups')); executor.spin()"


@pytest.mark.parametrize(("spin", "period"), [("rclpy.spin(Sleepy())", 0.2), (GROUPS, 0.05)])
def test_sleep_blocks_one_thread_and_callback_groups_keep_the_control_rate(
    run_node: RunNode, spin: str, period: float
) -> None:
    recording = run_node(SLEEPY + f"    {spin}", 4.0)

    np.testing.assert_allclose(np.diff(times(recording, "/cmd_vel")), period, atol=2e-6)
    measured = [float(text) for text in said(recording)]
    assert len(measured) > 10
    np.testing.assert_allclose(measured, 0.2, atol=2e-6)  # as a profiler in the node sees it


OWN_TYPES = """
    class Own(int): pass
    class Name(str):
        def __str__(self): return self
    class Stop(Exception):
        def __str__(self): return Name("its own text")
    class Halt(Twist): pass
    rclpy.init()
    node = Echo(Name("echo"))
    node.latch = node.create_publisher(Halt, Name("/halt"), True)
    node.other = node.create_publisher(Twist, "/other", Own(4))
    node.many = [node.create_publisher(Twist, f"/t{i}", 1) for i in range(520)]
    node.latch.publish(Halt())
    for _ in range(3): rclpy.spin_once(node)
    raise Stop()
"""


def test_what_rclpy_takes_is_reported_whatever_its_type(run_node: RunNode) -> None:
    recording = run_node(OWN_TYPES)

    assert end_of(recording) == "exception", recording
    assert "its own text" in recording.ended.text
    ends = {end.topic: end for end in recording.endpoints}
    assert (ends["/halt"].type, ends["/halt"].depth) == ("geometry_msgs/msg/Twist", 1)
    assert (ends["/other"].depth, "/t519" in ends) == (4, True)


def test_parameters_and_remapping_come_from_the_command_line(run_node: RunNode) -> None:
    source = """
        class Parametrised(Echo):
            def on_scan(self, scan):
                twist = Twist()
                twist.linear.x = self.get_parameter('speed').value
                self.publisher.publish(twist)
        rclpy.init()
        node = Parametrised()
        node.declare_parameter('speed', 0.1)
        rclpy.spin(node)
    """
    arguments = ("--ros-args", "-p", "speed:=0.25", "-r", "__node:=renamed")
    recording = run_node(source, arguments=arguments)

    assert {twist.linear.x for twist in sent(recording, "/cmd_vel")} == {0.25}
    assert {endpoint.node for endpoint in recording.endpoints} == {"/renamed"}


def test_a_host_begins_with_what_each_node_needs(run_node: RunNode) -> None:
    """Its fork server has loaded the libraries, and left no gaps in the heap to be copied."""
    run = run_node("""
        import ctypes
        class Heap(ctypes.Structure):
            _fields_ = [("other", ctypes.c_size_t * 8), ("free", ctypes.c_size_t),
                        ("at_its_end", ctypes.c_size_t)]
        libc = ctypes.CDLL(None)
        libc.mallinfo2.restype = Heap
        heap = libc.mallinfo2()
        def loaded(): return {line.split()[-1] for line in open("/proc/self/maps") if ".so" in line}
        before = loaded()
        rclpy.init(); Echo()
        print(heap.free - heap.at_its_end, *(loaded() - before))
    """)

    gaps, *libraries = said(run)[0].split()
    assert libraries == []
    assert int(gaps) < 600_000  # [bytes]; 740,000 where they are not taken up
