"""How a student's program can end, and what the judge gets to know of it."""

import os
import signal

import numpy as np
import pytest
from node_runs import RunNode

from grader.link.output import MAX_OUTPUT
from grader.trial.virtual_time import Limits

# --- how a program can end -----------------------------------------------------------------------

ENDS = {
    "syntax_error": ("def broken(:\n    pass", "SyntaxError in line"),
    "exception": ("rclpy.init(); Echo().nonsense", "no attribute 'nonsense' (line"),
    "returned": ("rclpy.init(); Echo()", "the program ran to its end"),
    "exited": ("rclpy.init(); sys.exit(3)", "sys.exit(3)"),
    "died": ("rclpy.init(); os._exit(5)", "exit code 5"),
    "never_spun": ("rclpy.init(); Echo()\nwhile True: time.sleep(1)", "never spins"),
}


@pytest.mark.parametrize("kind", ENDS)
def test_each_end_has_a_name(kind: str, run_node: RunNode) -> None:
    source, text = ENDS[kind]
    outcome = run_node(source).outcome

    assert (outcome.kind, text in outcome.text) == (kind, True), outcome


def test_an_exception_in_a_callback_shows_the_students_lines_only(run_node: RunNode) -> None:
    outcome = run_node("""
        class Fragile(Echo):
            def on_scan(self, scan):
                1 / 0
        rclpy.init(); rclpy.spin(Fragile())
    """).outcome

    assert outcome.kind == "exception"
    assert outcome.text.startswith("ZeroDivisionError: division by zero (line ")
    assert outcome.text.endswith("in on_scan)")
    assert outcome.at < 0.2
    assert 'File "node.py"' in outcome.detail
    assert "grader" not in outcome.detail


def test_a_callback_that_never_returns_is_located(run_node: RunNode) -> None:
    source = """
        class Hanging(Echo):
            def on_scan(self, scan):
                while True:
                    pass
        rclpy.init(); rclpy.spin(Hanging())
    """
    outcome = run_node(source, limits=Limits(start=20, step=0.5, total=30)).outcome

    assert outcome.kind == "hung"
    assert "in on_scan" in outcome.detail


def test_a_crash_of_native_code_is_a_death(run_node: RunNode) -> None:
    outcome = run_node("import ctypes; ctypes.string_at(0)").outcome

    assert (outcome.kind, f"signal {int(signal.SIGSEGV)}" in outcome.text) == ("died", True)


def test_a_blocking_call_in_a_callback_is_a_deadlock(run_node: RunNode) -> None:
    outcome = run_node("""
        from std_srvs.srv import Trigger
        class Server(Node):
            def __init__(self):
                super().__init__('server')
                self.create_service(Trigger, 'ask', lambda request, response: response)
        class Blocking(Echo):
            def on_scan(self, scan):
                self.create_client(Trigger, 'ask').call(Trigger.Request())
        rclpy.init(); executor = SingleThreadedExecutor()
        executor.add_node(Server()); executor.add_node(Blocking()); executor.spin()
    """).outcome

    assert outcome.kind == "stuck"
    assert "call()" in outcome.text


def test_odd_encodings_run(run_node: RunNode) -> None:
    lines = ("import rclpy", "from rclpy.node import Node", "rclpy.init()")
    source = "\r\n".join((*lines, "rclpy.spin(Node('ü'[:0] + 'n'))", ""))
    assert run_node(b"\xef\xbb\xbf" + source.encode()).outcome.completed
    assert run_node(b"# coding: latin-1\n" + source.encode("latin-1")).outcome.completed
    assert run_node(b"name = '\xff'\n").outcome.kind == "syntax_error"


# --- what the judge gets to know -----------------------------------------------------------------


def test_the_log_has_levels_and_times(run_node: RunNode) -> None:
    recording = run_node("""
        class Talkative(Echo):
            def on_scan(self, scan):
                self.get_logger().warning('careful')
                print('printed')
                print('complained', file=sys.stderr)
        rclpy.init(); rclpy.spin(Talkative())
    """)

    said = {(line.level, line.text) for line in recording.log}
    assert said == {("warn", "careful"), ("stdout", "printed"), ("stderr", "complained")}
    np.testing.assert_allclose(
        [line.t for line in recording.log if line.level == "warn"], recording.times("/scan")
    )


def test_endless_output_is_cut(run_node: RunNode) -> None:
    recording = run_node("""
        class Flood(Echo):
            def on_scan(self, scan):
                print('x' * 100_000)
                super().on_scan(scan)
        rclpy.init(); rclpy.spin(Flood())
    """)

    assert recording.outcome.completed
    assert recording.log_truncated
    assert sum(len(line.text) for line in recording.log) <= MAX_OUTPUT
    assert len(recording.published) == 20


def test_a_wrong_type_is_silence_and_is_reported(run_node: RunNode) -> None:
    recording = run_node("""
        rclpy.init(); node = Node('stamped')
        node.create_publisher(TwistStamped, '/cmd_vel', 10)
        node.create_subscription(String, '/scan', print, 10)
        rclpy.spin(node)
    """)

    assert recording.outcome.completed
    publisher, subscription = recording.endpoints
    assert publisher.type == "geometry_msgs/msg/TwistStamped"
    assert "sensor_msgs/msg/LaserScan" in subscription.mismatch
    assert recording.log == ()


def test_incompatible_qos_is_silence_and_is_reported(run_node: RunNode) -> None:
    recording = run_node("""
        from rclpy.qos import DurabilityPolicy, QoSProfile
        rclpy.init(); node = Node('picky')
        qos = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        node.create_subscription(LaserScan, '/scan', print, qos)
        rclpy.spin(node)
    """)

    (subscription,) = recording.endpoints
    assert subscription.mismatch == "volatile publisher and transient local subscription"
    assert [line.level for line in recording.log] == ["warn"]  # rclpy's own


def test_a_node_that_speaks_for_the_robot_is_kept_apart(run_node: RunNode) -> None:
    recording = run_node("""
        class Ventriloquist(Echo):
            def __init__(self):
                super().__init__()
                self.create_publisher(LaserScan, '/scan', 10).publish(LaserScan())
        rclpy.init(); rclpy.spin(Ventriloquist())
    """)

    assert recording.published[0].topic == "/from_node/scan"
    assert len(recording.scans()) == 20


def test_hosts_leave_no_shared_memory_behind(run_node: RunNode) -> None:
    recording = run_node("""
        rclpy.init(); node = Echo()
        print(*(f for f in sorted(os.listdir('/dev/shm')) if 'port' not in f))
        rclpy.spin(node)
    """)

    (line,) = [line.text for line in recording.log if line.level == "stdout"]
    assert "fastrtps_" in line
    assert not set(line.split()) & set(os.listdir("/dev/shm"))


@pytest.mark.skipif(os.getuid() != 0, reason="only root can become another user")
def test_students_code_is_not_root(run_node: RunNode) -> None:
    recording = run_node("""
        rclpy.init()
        print(os.getuid() in range(61184, 65520), os.access('/etc/shadow', os.R_OK))
        rclpy.spin(Echo())
    """)

    assert [line.text for line in recording.log if line.level == "stdout"] == ["True False"]
