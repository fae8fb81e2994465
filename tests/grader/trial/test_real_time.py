"""Nodes in real time, on DDS. What they do is asserted; how fast the machine is, never."""

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import msgspec
import numpy as np
import pytest
from node_runs import PREAMBLE, short

from grader.course.submission import Package, Program, Submission
from grader.recording import Recording, bag, ended_of
from grader.trial.real_time import run_live_trial
from rclpy_virtual_time.host.real_time.robot import _moment
from rclpy_virtual_time.host.robot_ends import Heard
from rclpy_virtual_time.link.hosts import ForkServer
from rclpy_virtual_time.link.live_hosts import LiveHosts
from sim.messages import EPOCH_NS, STRING, decode
from sim.scenario import ProgramSpec

RunLive = Callable[..., Recording]


def test_every_scan_is_answered_over_dds(run_live: RunLive, tmp_path: Path) -> None:
    """Stamps and clocks are of today, a bag keeps all of it, and the judge its priority."""
    before = os.sched_getscheduler(0), os.sched_getparam(0)
    source = """
        class Clock(Echo):
            def on_scan(self, scan):
                super().on_scan(scan)
                age = self.get_clock().now() - rclpy.time.Time.from_msg(scan.header.stamp)
                print('fresh' if 0 <= age.nanoseconds < 60e9 else age)
        rclpy.init(); rclpy.spin(Clock())
    """
    recording = run_live(source, reason="because")

    assert recording.outcome.completed
    assert (len(recording.scans()), len(recording.twists().t)) == (10, 10)
    assert [(end.kind, end.topic, end.matched) for end in recording.endpoints] == [
        ("publisher", "/cmd_vel", True),
        ("subscription", "/scan", True),
    ]
    assert {line.text for line in recording.log} == {"fresh"}
    assert recording.epoch > EPOCH_NS
    stamps = [scan.stamp for scan in recording.scans()]
    assert np.allclose(stamps, recording.times("/scan"))
    again = bag.load(bag.save(recording, tmp_path / "bag"))
    assert (again.digest(), again.live) == (recording.digest(), recording.live)
    assert again.live is not None and again.live.reason == "because"
    assert [scan.stamp for scan in again.scans()] == stamps
    assert (os.sched_getscheduler(0), os.sched_getparam(0)) == before


@pytest.mark.parametrize(
    ("sent", "moment"),
    [
        (9.99, 9.99),
        (9.5, 9.975),  # so long ago it can't have been: who says so wants to have been in time
        (10.5, 10.0),  # nor later than it came
    ],
)
def test_a_message_counts_from_when_it_was_sent_within_limits(sent: float, moment: float) -> None:
    heard = Heard(int(sent * 1e9), 10_000_000_000, "/t", "a/msg/B", b"")
    assert _moment(heard, begun=True) == int(moment * 1e9)
    assert _moment(heard, begun=False) == int(min(sent, 10.0) * 1e9)  # nothing is won by that


ENDS = {
    "exception": "raise KeyError('x')",
    "returned": "rclpy.init(); Echo()",
    "died": "os._exit(7)",
    "never_spun": "rclpy.init(); node = Echo(); threading.Event().wait()",
}


@pytest.mark.parametrize("kind", ENDS)
def test_each_end_has_a_name(kind: str, run_live: RunLive, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rclpy_virtual_time.link.live_hosts.IDLE_START", 0.5)
    assert run_live(ENDS[kind]).outcome.kind == kind


def test_a_callback_that_never_returns_hangs(
    run_live: RunLive, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("grader.trial.real_time.HUNG_AFTER", 0.5)
    recording = run_live("""
        class Stuck(Echo):
            def on_scan(self, scan):
                while True: pass
        rclpy.init(); rclpy.spin(Stuck())
    """)

    assert recording.outcome.kind == "hung"
    assert "on_scan" in recording.outcome.detail


def test_a_wrong_type_is_silence_and_is_reported(run_live: RunLive) -> None:
    recording = run_live("""
        rclpy.init(); node = Node('deaf')
        node.create_subscription(String, '/scan', print, 10)
        rclpy.spin(node)
    """, short(0.3))  # fmt: skip

    (end,) = recording.endpoints
    assert end.mismatch == "the robot publishes sensor_msgs/msg/LaserScan"
    assert recording.log == ()


def test_a_node_that_speaks_for_the_robot_is_kept_apart(run_live: RunLive) -> None:
    recording = run_live("""
        class Liar(Echo):
            def __init__(self):
                super().__init__()
                self.liar = self.create_publisher(LaserScan, '/scan', 10)
            def on_scan(self, scan):
                if scan.ranges: self.liar.publish(LaserScan())
        rclpy.init(); rclpy.spin(Liar())
    """)

    assert len(recording.scans()) == 10
    assert len(recording.of("/from_node/scan")) > 0


def test_a_node_that_closes_its_output_does_not_keep_the_judge_busy(
    run_live: RunLive, monkeypatch: pytest.MonkeyPatch
) -> None:
    listen = LiveHosts.listen
    looks = []

    def counting(hosts: LiveHosts, patience: float) -> None:
        looks.append(hosts.epoch)
        listen(hosts, patience)

    monkeypatch.setattr(LiveHosts, "listen", counting)
    recording = run_live("os.close(1); os.close(2); rclpy.init(); rclpy.spin(Echo())")

    assert recording.outcome.completed
    assert sum(epoch > 0 for epoch in looks) < 400  # in one second; a closed pipe is always ready


BEATING = """
class Beating(Node):
    def __init__(self):
        super().__init__('beating')
        self.count = 0
        self.publisher = self.create_publisher(String, '/beat', 10)
        self.create_timer(0.02, self.on_timer)
    def on_timer(self):
        self.publisher.publish(String(data=str(self.count)))
        self.count += 1
rclpy.init(); rclpy.spin(Beating())
"""
LATE = """
class Late(Echo):
    def __init__(self):
        super().__init__('late')
        time.sleep(0.5)
        twist = Twist(); twist.linear.x = 0.25; self.publisher.publish(twist)
rclpy.init(); rclpy.spin(Late())
"""


def test_each_of_several_programs_has_a_start_up_of_its_own(
    forkserver: ForkServer, tmp_path: Path
) -> None:
    """What one says between its start-up and the beginning is dropped; the other still starts."""
    beating, late = tmp_path / "beating.py", tmp_path / "late.py"
    beating.write_text(PREAMBLE + BEATING)
    late.write_text(PREAMBLE + LATE)
    programs = (ProgramSpec("beating.py"), ProgramSpec("late.py"))
    scenario = msgspec.structs.replace(short(1.0), program=programs)
    recording = run_live_trial(Submission(beating, others=(late,)), scenario, forkserver)

    assert recording.outcome.completed, recording.outcome
    twists = recording.twists()
    assert (twists.t[0], twists.linear_x[0]) == (0.0, 0.25)
    beats = [int(decode(message.data, STRING).data) for message in recording.of("/beat")]
    assert np.count_nonzero(recording.times("/beat") == 0.0) <= 1
    assert beats == list(range(beats[0], beats[0] + len(beats)))


def test_one_of_several_that_ends_leaves_the_others_alone(
    forkserver: ForkServer, tmp_path: Path
) -> None:
    sources = {"stays.py": "rclpy.init(); rclpy.spin(Echo())", "spare.py": "rclpy.init(); 1 / 0"}
    for name, source in sources.items():
        (tmp_path / name).write_text(PREAMBLE + source)
    files = {name: tmp_path / name for name in sources}
    package = Package(programs=tuple(map(Program, files)))
    submission = Submission(files["stays.py"], beside=files, package=package)
    recording = run_live_trial(submission, short(0.5), forkserver)

    assert recording.outcome.completed, recording.outcome
    (said,) = ended_of(recording)
    assert said.startswith("spare.py ended at 0.0 s: ZeroDivisionError")


def test_two_trials_at_once_do_not_hear_each_other(run_live: RunLive) -> None:
    def run(speed: float) -> Recording:
        source = f"""
            class Drive(Echo):
                def on_scan(self, scan):
                    twist = Twist(); twist.linear.x = {speed}; self.publisher.publish(twist)
            rclpy.init(); rclpy.spin(Drive())
        """
        return run_live(source, name=f"drives_at_{speed}.py")

    speeds = (0.1, 0.2)
    with ThreadPoolExecutor(2) as pool:
        for speed, recording in zip(speeds, pool.map(run, speeds), strict=True):
            assert recording.twists().linear_x.tolist() == [speed] * 10
