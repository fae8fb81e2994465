"""How a student's program can end, and what the judge gets to know of it."""

import os
import signal

import numpy as np
import pytest

from rclpy_virtual_time.link.exchange import HostDied, HostHung
from rclpy_virtual_time.link.output import MAX_OUTPUT
from rclpy_virtual_time.link.shared_memory import OURS
from rclpy_virtual_time.tests.runs import RunNode, end_of, said, scans

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
    ("rclpy.init(); Echo()\nwhile True: time.sleep(1)", "never_spun", ""),
    ("time.sleep(3600); rclpy.init(); rclpy.spin(Node('late'))", "never_spun", ""),
    ("rclpy.init(); Node('mute'); threading.Event().wait()", "never_spun", ""),
)


@pytest.mark.parametrize(("source", "kind", "text"), ENDS)
def test_each_end_has_a_name(source: str, kind: str, text: str, run_node: RunNode) -> None:
    try:
        run = run_node(source)
    except HostDied as died:
        assert (kind, str(died)) == ("died", text)
    else:
        assert (end_of(run), text in (run.ended.text if run.ended else "")) == (kind, True), run


def test_an_exception_in_a_callback_shows_the_students_lines_only(run_node: RunNode) -> None:
    run = run_node("""
        class Fragile(Echo):
            def on_scan(self, scan):
                1 / 0
        rclpy.init(); rclpy.spin(Fragile())
    """)

    assert (end_of(run), run.now < 200_000_000) == ("exception", True)
    outcome = run.ended
    assert outcome.text.startswith("ZeroDivisionError: division by zero (line ")
    assert outcome.text.endswith("in on_scan)")
    assert 'File "node.py"' in outcome.detail
    assert "rclpy_virtual_time" not in outcome.detail


def test_a_callback_that_never_returns_is_located(run_node: RunNode) -> None:
    source = """
        class Hanging(Echo):
            def on_scan(self, scan):
                while True:
                    pass
        rclpy.init(); rclpy.spin(Hanging())
    """
    with pytest.raises(HostHung) as hung:
        run_node(source, limit=3.0)
    assert "in on_scan" in hung.value.stacks


def test_a_blocking_call_in_a_callback_is_a_deadlock(run_node: RunNode) -> None:
    run = run_node("""
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
    """)

    assert end_of(run) == "stuck"
    assert "in on_scan" in run.stacks and "in call" in run.stacks, run.stacks


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

    lines = {(line.level, line.text) for line in recording.log}
    assert lines == {("warn", "careful"), ("stdout", "printed"), ("stderr", "complained")}
    warned = [line.time for line in recording.log if line.level == "warn"]
    scanned = [time for time, _ in scans(2 * 10**9)]
    np.testing.assert_allclose(warned, scanned, rtol=1e-7)


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
    assert (end_of(recording), subscription.mismatch) == ("completed", mismatch)
    assert [line.level for line in recording.log] == levels  # rclpy's own words


def test_hosts_leave_no_shared_memory_behind(run_node: RunNode) -> None:
    recording = run_node("""
        rclpy.init(); node = Echo()
        print(*(f for f in sorted(os.listdir('/dev/shm')) if 'port' not in f))
        rclpy.spin(node)
    """)

    (line,) = said(recording)
    assert line.startswith(OURS)
    assert not set(line.split()) & set(os.listdir("/dev/shm"))


def test_endless_output_is_cut(run_node: RunNode) -> None:
    recording = run_node("""
        rclpy.init(); node = Echo()
        for _ in range(30): print('x' * 100_000)
        rclpy.spin(node)
    """)

    assert (end_of(recording), recording.truncated) == ("completed", True)
    assert sum(len(line.text) for line in recording.log) <= MAX_OUTPUT
