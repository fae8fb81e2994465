"""What computing costs in a drive: nothing in virtual time, unless it is charged."""

from pathlib import Path

import numpy as np
import pytest
from drives import drive_file, summary

from grader.drive import print_summary
from grader.recording import costs_of
from rclpy_virtual_time.link.hosts import ForkServer

COMPUTES = """
class Computes(Echo):
    def on_scan(self, scan):
        {before}
        end = time.process_time() + 0.3
        while time.process_time() < end:
            pass
        {after}
        super().on_scan(scan)
rclpy.init(); rclpy.spin(Computes())
"""
LEAST = 0.299999  # [s] of the 0.3: a clock read before it may be ahead by 1 µs
SILENT = {"before": "", "after": ""}
MEASURES = {"before": "began = time.perf_counter()", "after": "print(time.perf_counter() - began)"}
ROS_TIME = {
    "before": "began = self.get_clock().now()",
    "after": "print((self.get_clock().now() - began).nanoseconds / 1e9)",
}


def test_computing_costs_no_time(
    tmp_path: Path, forkserver: ForkServer, capsys: pytest.CaptureFixture[str]
) -> None:
    recording = drive_file(tmp_path, forkserver, COMPUTES.format(**MEASURES).replace("0.3", "0.11"))
    costs = costs_of(recording)
    said = summary(recording, capsys)

    assert len(recording.twists().t) == 10
    measured = {float(line.text) for line in recording.log}
    assert max(measured) < 2e-6  # what reading the clock takes
    assert costs is not None
    assert 0.1 < costs.p50 <= costs.p99 <= costs.worst
    assert (costs.late, costs.period, costs.keeps_up) == (10, 0.1, False)
    assert "/cmd_vel geometry_msgs/msg/Twist reliable 10 messages (10.0 Hz)" in said
    assert "the lidar's period is 100 ms WARNING: the node can't keep up" in said
    assert "of 10 scans a second" in said


@pytest.mark.parametrize(
    "reads",
    [
        pytest.param(SILENT, id="silent"),
        pytest.param(MEASURES, id="steady", marks=pytest.mark.long),
        pytest.param(ROS_TIME, id="ros", marks=pytest.mark.long),
    ],
)
def test_computing_costs_time_if_charged(
    tmp_path: Path, forkserver: ForkServer, reads: dict[str, str]
) -> None:
    recording = drive_file(tmp_path, forkserver, COMPUTES.format(**reads), charge_compute=True)
    t = recording.twists().t

    assert recording.outcome.completed, recording.outcome
    assert len(recording.times("/scan")) == 10
    assert len(t) in (2, 3)
    first, *between = np.diff(t, prepend=recording.times("/scan")[0]).round(6)
    assert first >= LEAST
    assert all(span >= LEAST for span in between)
    assert all(round(float(line.text), 6) >= LEAST for line in recording.log)
    assert len(recording.log) >= (0 if reads is SILENT else 2)


def test_a_sleep_begins_after_what_was_computed(tmp_path: Path, forkserver: ForkServer) -> None:
    source = COMPUTES.format(before="", after="time.sleep(0.2)")
    recording = drive_file(tmp_path, forkserver, source, charge_compute=True)

    assert round(recording.twists().t[0] - recording.times("/scan")[0], 6) >= 0.5


def test_only_the_computing_of_the_scenario_is_charged(
    tmp_path: Path, forkserver: ForkServer, capsys: pytest.CaptureFixture[str]
) -> None:
    """Its start-up is not, nor is what the host does between the node's callbacks."""
    start_up = "end = time.process_time() + 0.5\nwhile time.process_time() < end: pass\n"
    recording = drive_file(
        tmp_path, forkserver, start_up + "rclpy.init(); rclpy.spin(Echo())", charge_compute=True
    )
    lag = recording.twists().t - recording.times("/scan")
    capsys.readouterr()
    print_summary(recording, file="echo.py")

    assert len(lag) == 10
    assert (lag < 0.05).all()
    assert "--charge-compute" in capsys.readouterr().out
