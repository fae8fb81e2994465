"""Signals that a node's program sends itself (signals.py); see test_several_programs.py, too."""

import pytest

from rclpy_virtual_time.tests.runs import RunNode, end_of, said


@pytest.mark.parametrize("number, end", [("SIGINT", "KeyboardInterrupt"), ("SIGTERM", "none")])
def test_a_thread_interrupts_its_own_program(run_node: RunNode, number: str, end: str) -> None:
    recording = run_node(f"""
        import os, signal
        rclpy.init(); node = rclpy.create_node('n')
        threading.Timer(0.5, os.kill, [os.getpid(), signal.{number}]).start()
        end = 'none'
        try: rclpy.spin(node)
        except KeyboardInterrupt: end = 'KeyboardInterrupt'
        except rclpy.executors.ExternalShutdownException: pass
        print(end, round(time.monotonic() - 1000, 1), rclpy.ok())
    """)
    assert (end_of(recording), recording.now) == ("returned", pytest.approx(5e8))
    assert said(recording)[0].split()[::2] == [end, "False"]


def test_a_signal_ends_a_pause(run_node: RunNode) -> None:
    recording = run_node("""
        import os, signal
        signal.signal(signal.SIGUSR1, lambda number, frame: print('handled'))
        threading.Timer(0.5, os.kill, [os.getpid(), signal.SIGUSR1]).start()
        rclpy.init(); node = rclpy.create_node('n'); rclpy.spin_once(node, timeout_sec=0.1)
        signal.pause(); print('paused')
        threading.Timer(0.5, signal.raise_signal, [signal.SIGUSR1]).start()
        time.sleep(1.0); print('slept')
    """)
    assert said(recording) == ["handled", "paused", "handled", "slept"]
    assert recording.now == pytest.approx(1.5e9)
