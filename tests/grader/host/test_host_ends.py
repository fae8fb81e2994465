"""How a student's program can end, and what the judge gets to know of it."""

import os
import signal

import numpy as np
import pytest
from node_runs import RunNode

from grader.trial.virtual_time import Limits
from rclpy_virtual_time.link.output import MAX_OUTPUT

# --- how a program can end -----------------------------------------------------------------------

ENDS = (
    ("def broken(:\n    pass", "syntax_error", "SyntaxError in line"),
    ("rclpy.init(); Echo().nonsense", "exception", "no attribute 'nonsense' (line"),
    ("raise ValueError(os.fsdecode(b'caf\\xe9'))", "exception", "ValueError: caf?"),
    ("raise KeyboardInterrupt()", "exception", ""),
    ("raise BaseException('b')", "exception", ""),
    ("time.sleep(1.0); raise ValueError('no')", "exception", ""),
    ("rclpy.init(); Echo()", "returned", "the program ran to its end"),
    ("def main(): rclpy.init()", "returned", "ran to its end and made no node"),
    ("rclpy.init(); sys.exit(3)", "exited", "sys.exit(3)"),
    ("rclpy.init(); os._exit(5)", "died", "exit code 5"),
    ("import ctypes; ctypes.string_at(0)", "died", f"signal {int(signal.SIGSEGV)}"),
    ("rclpy.init(); Echo()\nwhile True: time.sleep(1)", "never_spun", "never spins"),
    ("time.sleep(3600); rclpy.init(); rclpy.spin(Node('late'))", "never_spun", ""),
    ("rclpy.init(); Node('mute'); threading.Event().wait()", "never_spun", ""),
)


@pytest.mark.parametrize(("source", "kind", "text"), ENDS)
def test_each_end_has_a_name(source: str, kind: str, text: str, run_node: RunNode) -> None:
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
    assert "call()" in outcome.detail


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


PAST = "QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)"


@pytest.mark.parametrize(
    ("type", "qos", "mismatch", "levels"),
    [
        ("String", "10", "the robot publishes sensor_msgs/msg/LaserScan", []),
        ("LaserScan", PAST, "volatile publisher and transient local subscription", ["warn"]),
    ],
)
def test_a_wrong_type_or_qos_is_silence_and_is_reported(
    run_node: RunNode, type: str, qos: str, mismatch: str, levels: list[str]
) -> None:
    recording = run_node(f"""
        from rclpy.qos import DurabilityPolicy, QoSProfile
        rclpy.init(); node = Node('deaf')
        node.create_subscription({type}, '/scan', print, {qos})
        rclpy.spin(node)
    """)

    (subscription,) = recording.endpoints
    assert (recording.outcome.completed, subscription.mismatch) == (True, mismatch)
    assert [line.level for line in recording.log] == levels  # rclpy's own words


def test_hosts_leave_no_shared_memory_behind(run_node: RunNode) -> None:
    recording = run_node("""
        rclpy.init(); node = Echo()
        print(*(f for f in sorted(os.listdir('/dev/shm')) if 'port' not in f))
        rclpy.spin(node)
    """)

    (line,) = [line.text for line in recording.log if line.level == "stdout"]
    assert "fastrtps_" in line
    assert not set(line.split()) & set(os.listdir("/dev/shm"))


def test_endless_output_is_cut(run_node: RunNode) -> None:
    recording = run_node("""
        rclpy.init(); node = Echo()
        for _ in range(30): print('x' * 100_000)
        rclpy.spin(node)
    """)

    assert (recording.outcome.completed, recording.log_truncated) == (True, True)
    assert sum(len(line.text) for line in recording.log) <= MAX_OUTPUT
