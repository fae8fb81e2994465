"""Nodes in real time, on DDS. What they do is asserted; how fast the machine is, never."""

import os
import textwrap
import threading
from collections.abc import Callable, Sequence
from pathlib import Path

import msgspec
import numpy as np
import pytest
from node_runs import PREAMBLE, RunNode, short

from grader.course.exercises import find_exercise
from grader.course.submission import Submission
from grader.errors import GraderError
from grader.grading.grading import grade_submission
from grader.host.real_time.robot import _moment
from grader.host.robot_ends import Heard
from grader.link.hosts import ForkServer
from grader.recording import Recording, bag
from grader.trial.real_time import _LiveTrial, run_live_trial
from grader.trial.real_time_hosts import LiveHosts
from grader.trial.trials import NodeTrials
from grader.trial.virtual_time import Limits
from sim.messages import EPOCH_NS, STRING, Message, decode
from sim.scenario import ProgramSpec, Scenario, ScriptEvent

RunLive = Callable[..., Recording]


@pytest.fixture
def run_live(forkserver: ForkServer, tmp_path: Path) -> RunLive:
    """Run a few lines of node (after PREAMBLE) in a scenario, in real time."""

    def run(source: str, scenario: Scenario | None = None, **options: object) -> Recording:
        file = tmp_path / "node.py"
        file.write_text(PREAMBLE + textwrap.dedent(source))
        return run_live_trial(
            Submission(file),
            scenario or short(1.0),
            forkserver,
            **options,  # type: ignore[arg-type]
        )

    return run


def test_every_scan_is_answered_over_dds(run_live: RunLive) -> None:
    recording = run_live("rclpy.init(); rclpy.spin(Echo())")

    assert recording.outcome.completed
    assert len(recording.scans()) == 10
    assert len(recording.twists().t) == 10
    assert recording.live is not None
    assert [(end.kind, end.topic, end.matched) for end in recording.endpoints] == [
        ("publisher", "/cmd_vel", True),
        ("subscription", "/scan", True),
    ]


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


def test_stamps_and_clocks_are_of_today(run_live: RunLive) -> None:
    recording = run_live("""
        class Clock(Echo):
            def on_scan(self, scan):
                age = self.get_clock().now() - rclpy.time.Time.from_msg(scan.header.stamp)
                print('fresh' if 0 <= age.nanoseconds < 60e9 else age)
        rclpy.init(); rclpy.spin(Clock())
    """)

    assert {line.text for line in recording.log} == {"fresh"}
    assert recording.epoch > EPOCH_NS
    assert np.allclose([scan.stamp for scan in recording.scans()], recording.times("/scan"))


def test_commands_move_the_robot(run_live: RunLive) -> None:
    recording = run_live("""
        class Drive(Echo):
            def on_scan(self, scan):
                twist = Twist(); twist.linear.x = 0.3; self.publisher.publish(twist)
        rclpy.init(); rclpy.spin(Drive())
    """, short(1.5))  # fmt: skip

    assert recording.truth.x[-1] - recording.truth.x[0] > 0.1


def test_a_goal_and_what_is_said_about_it(run_live: RunLive) -> None:
    scenario = msgspec.structs.replace(
        short(1.0, "demo_open"), script=(ScriptEvent(at=0.25, goal=(1.0, -2.0, 0.0)),)
    )
    recording = run_live(
        """
        from geometry_msgs.msg import PoseStamped
        rclpy.init(); node = Node('listener')
        node.create_subscription(PoseStamped, 'goal_pose',
            lambda goal: print(goal.pose.position.x, goal.pose.position.y), 10)
        rclpy.spin(node)
        """,
        scenario,
    )

    assert [line.text for line in recording.log] == ["1.0 -2.0"]
    assert recording.log[0].t >= 0.25
    assert (recording.goals().x, recording.goals().y) == ([1.0], [-2.0])


ENDS = {
    "exception": "raise KeyError('x')",
    "exited": "rclpy.init(); sys.exit(3)",
    "returned": "rclpy.init(); Echo()",
    "syntax_error": "def",
    "died": "os._exit(7)",
    "never_spun": "rclpy.init(); node = Echo(); threading.Event().wait()",
}


@pytest.mark.parametrize("kind", ENDS)
def test_each_end_has_a_name(kind: str, run_live: RunLive, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("grader.trial.real_time_hosts.IDLE_START", 0.5)
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
    """)

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


def test_two_trials_at_once_do_not_hear_each_other(forkserver: ForkServer, tmp_path: Path) -> None:
    recordings: dict[str, Recording] = {}

    def run(name: str, speed: float) -> None:
        file = tmp_path / f"{name}.py"
        file.write_text(
            PREAMBLE
            + textwrap.dedent(f"""
            class Drive(Echo):
                def on_scan(self, scan):
                    twist = Twist(); twist.linear.x = {speed}; self.publisher.publish(twist)
            rclpy.init(); rclpy.spin(Drive())
            """)
        )
        recordings[name] = run_live_trial(Submission(file), short(1.0), forkserver)

    threads = [threading.Thread(target=run, args=pair) for pair in (("slow", 0.1), ("fast", 0.2))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()

    assert set(recordings["slow"].twists().linear_x) == {0.1}
    assert set(recordings["fast"].twists().linear_x) == {0.2}
    assert all(len(recording.twists().t) == 10 for recording in recordings.values())


def test_a_live_recording_survives_a_bag(run_live: RunLive, tmp_path: Path) -> None:
    recording = run_live("rclpy.init(); rclpy.spin(Echo())", reason="because")
    again = bag.load(bag.save(recording, tmp_path / "bag"))

    assert again.digest() == recording.digest()
    assert again.live == recording.live
    assert again.live is not None and again.live.reason == "because"
    assert [scan.stamp for scan in again.scans()] == [scan.stamp for scan in recording.scans()]


# --- what virtual time can't carry ---------------------------------------------------------------

UNVIRTUAL = {
    "EventsExecutor": """
        from rclpy.experimental.events_executor import EventsExecutor
        rclpy.init(); executor = EventsExecutor(); executor.add_node(Echo()); executor.spin()
    """,
    "while not done": """
        rclpy.init(); node = Echo()
        threading.Thread(target=rclpy.spin, args=(node,), daemon=True).start()
        while not getattr(node, 'done', False): pass
    """,
}


@pytest.mark.parametrize("style", UNVIRTUAL)
def test_what_virtual_time_cannot_carry_is_noticed(style: str, run_node: RunNode) -> None:
    recording = run_node(UNVIRTUAL[style], limits=Limits(start=1.0, step=1.0, total=5.0))
    assert recording.outcome.kind in ("real_time", "hung")


def test_it_is_graded_in_real_time_and_the_report_says_so(
    forkserver: ForkServer, tmp_path: Path
) -> None:
    exercise = find_exercise("obstacle_avoidance")
    source = (exercise.solutions / exercise.files[0]).read_text()
    spin = "        rclpy.spin(node)\n"
    assert spin in source
    own = """\
        from rclpy.experimental.events_executor import EventsExecutor
        executor = EventsExecutor()
        executor.add_node(node)
        executor.spin()
"""
    file = tmp_path / exercise.files[0]
    file.write_text(source.replace(spin, own))
    grading = grade_submission(
        exercise, Submission(file), forkserver, file=file.name, only=["clear_zone"]
    )

    outcomes = {check.id: check.outcome for check in grading.checks}
    assert "fail" not in outcomes.values()
    assert outcomes["wiring"] == "pass"
    (note,) = grading.as_dict()["notes"]
    assert "ran in real time" in note
    assert all(recording.live is not None for recording in grading.recordings)


@pytest.mark.long
def test_a_busy_wait_runs_in_real_time(forkserver: ForkServer, tmp_path: Path) -> None:
    file = tmp_path / "node.py"
    file.write_text(PREAMBLE + textwrap.dedent(UNVIRTUAL["while not done"]))
    limits = Limits(start=1.0, step=1.0, total=5.0)
    with NodeTrials(Submission(file), forkserver, limits=limits) as trials:
        first, second = trials.get("avoid_infinity"), trials.get("avoid_blind")

    for recording in (first, second):
        assert recording.outcome.completed
        assert recording.live is not None and "without letting time pass" in recording.live.reason
        assert len(recording.twists().t) == len(recording.scans())


@pytest.mark.long
def test_a_node_that_hangs_in_real_time_too_has_hung(
    forkserver: ForkServer, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("grader.trial.real_time.HUNG_AFTER", 0.5)
    exercise = find_exercise("obstacle_avoidance")
    file = tmp_path / exercise.files[0]
    file.write_text(
        PREAMBLE
        + textwrap.dedent("""
        class Stuck(Echo):
            def on_scan(self, scan):
                while True: pass
        rclpy.init(); rclpy.spin(Stuck())
        """)
    )
    grading = grade_submission(
        exercise, Submission(file), forkserver, file=file.name, only=["wiring"]
    )

    (check,) = grading.checks
    assert (check.outcome, check.actual) == ("fail", "hung")
    assert grading.as_dict()["notes"] == []


def test_wait_for_message_is_virtual(run_node: RunNode) -> None:
    recording = run_node("""
        from rclpy.wait_for_message import wait_for_message
        rclpy.init(); node = Node('patient')
        print(wait_for_message(LaserScan, node, '/scan')[0], time.monotonic())
        print(wait_for_message(LaserScan, node, '/other', time_to_wait=0.5), time.monotonic())
        rclpy.spin(Echo())
    """)

    assert recording.outcome.completed
    assert [line.text for line in recording.log] == ["True 1000.013", "(False, None) 1000.513"]
    assert len(recording.twists().t) == len(recording.scans()) - 6


def test_a_node_that_never_gets_started_is_not_run_again_and_again(
    forkserver: ForkServer, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("grader.trial.real_time_hosts.START_LIMIT", 0.5)
    file = tmp_path / "node.py"
    file.write_text("while True: pass")
    with NodeTrials(Submission(file), forkserver, limits=Limits(start=0.5, step=1.0)) as trials:
        first = trials.get("avoid_infinity")
        monkeypatch.setattr("grader.trial.trials.run_trial", None)
        second = trials.get("avoid_blind")

    assert [first.outcome.kind, second.outcome.kind] == ["hung", "hung"]
    assert second.duration_s == 0.0


def test_the_judge_gives_its_priority_back(run_live: RunLive) -> None:
    before = os.sched_getscheduler(0), os.sched_getparam(0)
    run_live("rclpy.init(); rclpy.spin(Echo())", short(0.2))
    assert (os.sched_getscheduler(0), os.sched_getparam(0)) == before


def test_a_killed_node_has_died_and_the_robot_comes_to_rest(run_live: RunLive) -> None:
    recording = run_live("""
        class Shot(Echo):
            scans = 0
            def on_scan(self, scan):
                twist = Twist(); twist.linear.x = 0.3; self.publisher.publish(twist)
                self.scans += 1
                if self.scans == 8: os.kill(os.getpid(), 9)
        rclpy.init(); rclpy.spin(Shot())
    """, short(4.0))  # fmt: skip

    truth, robot = recording.truth, recording.scenario.robot
    assert (recording.outcome.kind, "signal 9" in recording.outcome.text) == ("died", True)
    assert truth.v.max() > 0.1
    still_driven = recording.twists().t[-1] + robot.command_timeout
    rest = still_driven + 0.3 / robot.max_acceleration + 0.05
    assert np.all(truth.v[truth.t / 1e9 > rest] == 0.0)
    assert truth.v[-1] == 0.0


def test_a_killed_robot_is_no_verdict_on_the_node(
    run_live: RunLive, monkeypatch: pytest.MonkeyPatch
) -> None:
    transmit = _LiveTrial._transmit
    sent = []

    def shot(trial: _LiveTrial, messages: Sequence[Message]) -> None:
        transmit(trial, messages)
        sent.append(messages)
        if len(sent) == 5:
            trial.hosts.radio._host.kill()

    monkeypatch.setattr(_LiveTrial, "_transmit", shot)
    with pytest.raises(GraderError, match="the robot's radio has died"):
        run_live("rclpy.init(); rclpy.spin(Echo())", short(5.0))


AUTOGROUP = Path("/proc/self/autogroup")


@pytest.mark.skipif(os.geteuid() != 0, reason="only root may go before others")
@pytest.mark.skipif(not AUTOGROUP.exists(), reason="this kernel has no autogroups")
def test_robot_and_node_go_before_the_programs_of_other_sessions(
    run_live: RunLive, monkeypatch: pytest.MonkeyPatch
) -> None:
    transmit = _LiveTrial._transmit
    groups = {}

    def looking(trial: _LiveTrial, messages: Sequence[Message]) -> None:
        transmit(trial, messages)
        for host in (trial.hosts.radio._host, trial.hosts.programs[0].host):
            groups[host.pid] = Path(f"/proc/{host.pid}/autogroup").read_text().split()[-2:]

    mine = AUTOGROUP.read_text()
    monkeypatch.setattr(_LiveTrial, "_transmit", looking)
    run_live("rclpy.init(); rclpy.spin(Echo())", short(0.2))
    assert list(groups.values()) == [["nice", "-20"]] * 2
    assert AUTOGROUP.read_text() == mine


def test_what_a_constructor_says_to_nobody_is_on_the_record(run_live: RunLive) -> None:
    recording = run_live("""
        class Hasty(Echo):
            def __init__(self):
                super().__init__()
                twist = Twist(); twist.linear.x = 0.25; self.publisher.publish(twist)
        rclpy.init(); rclpy.spin(Hasty())
    """)

    twists = recording.twists()
    assert (twists.t[0], twists.linear_x[0]) == (0.0, 0.25)
    assert len(twists.t) == 11
