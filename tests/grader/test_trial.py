"""One trial: what the robot makes of what comes out of a host, and what no host can do."""

import os
import tempfile
import textwrap
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import msgspec
import numpy as np
import pytest
from conftest import RunNode, short
from fake_host import FakeHost, frame, settled

from grader import link, tape, trial
from grader.host.frames import (
    MAX_NAME,
    MAX_PUBLISHED,
    Ended,
    EndpointReport,
    Published,
    Slept,
    encode,
)
from grader.recording import Recording
from grader.submission import Submission
from grader.trial import Limits, run_trial
from sim.messages import LASER_SCAN, TWIST, TWIST_STAMPED, twist
from sim.scenario import Scenario, ScriptEvent

DRIVER = """
    class Driver(Node):
        def __init__(self, value, stamped=False):
            super().__init__('driver')
            self.value, self.stamped = value, stamped
            self.type = TwistStamped if stamped else Twist
            self.publisher = self.create_publisher(self.type, '/cmd_vel', 10)
            self.create_timer(0.1, self.on_timer)
        def on_timer(self):
            message = self.type()
            twist = message.twist if self.stamped else message
            twist.linear.x = self.value
            self.publisher.publish(message)
    rclpy.init()
"""


def drive(run_node: RunNode, arguments: str, **options: object) -> Recording:
    source = textwrap.dedent(DRIVER) + f"rclpy.spin(Driver({arguments}))\n"
    return run_node(source, short(1.0), **options)


# --- the robot and its commands ------------------------------------------------------------------


def test_the_robot_follows_its_commands(run_node: RunNode) -> None:
    recording = drive(run_node, "0.2")

    assert recording.outcome.completed
    assert recording.truth.v.max() == pytest.approx(0.2, abs=1e-3)
    assert recording.truth.t[np.argmax(recording.truth.v > 0)] / 1e9 == pytest.approx(
        0.12, abs=0.021
    )


def test_a_program_that_sleeps_before_it_spins_misses_nothing(run_node: RunNode) -> None:
    echo = """
        class Echo(Node):
            def __init__(self):
                super().__init__('echo')
                self.publisher = self.create_publisher(String, '/said', 10)
                self.create_subscription(LaserScan, '/scan', self.on_scan, 10)
                self.create_timer(0.25, lambda: self.say('timer'))
                print('ready', flush=True)
            def on_scan(self, scan):
                sent = scan.header.stamp.sec * 10**9 + scan.header.stamp.nanosec
                self.say(f'scan of {(self.get_clock().now().nanoseconds - sent) / 1e6:.0f} ms ago')
            def say(self, text):
                self.publisher.publish(String(data=f'{text} {time.time():.3f}'))
        rclpy.init()
        rclpy.spin(Echo())
    """
    source = textwrap.dedent(echo)
    late = "time.sleep(0.7)\nend = time.time() + 0.3\nwhile time.time() < end: pass\n" + source
    prompt, asleep = run_node(source, short(1.0)), run_node(late, short(1.0))

    assert asleep.outcome.completed
    assert asleep.published == prompt.published
    assert [line.time for line in asleep.log] == [0]


@pytest.mark.parametrize(
    ("source", "kind"),
    [
        ("time.sleep(3600); rclpy.init(); rclpy.spin(Node('late'))", "never_spun"),
        ("time.sleep(1.0); raise ValueError('no')", "exception"),
        ("time.sleep(1.0); rclpy.init(); Node('mute'); threading.Event().wait()", "never_spun"),
    ],
)
def test_a_program_that_sleeps_and_never_spins(run_node: RunNode, source: str, kind: str) -> None:
    assert run_node(source, short(1.0)).outcome.kind == kind


def test_a_program_that_speaks_before_it_spins_is_on_time(run_node: RunNode) -> None:
    recording = run_node(
        """
        rclpy.init()
        node = Node('speaker')
        publisher = node.create_publisher(String, '/said', 10)
        publisher.publish(String(data='here'))
        time.sleep(0.5)
        publisher.publish(String(data='still here'))
        rclpy.spin(node)
        """,
        short(1.0),
    )

    assert [message.time for message in recording.published] == [0, 500_000_000]


def test_without_commands_it_stands(run_node: RunNode) -> None:
    recording = run_node("rclpy.init(); rclpy.spin(Node('idle'))")

    assert recording.outcome.completed
    assert np.ptp(recording.truth.x) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("value", ["float('nan')", "float('inf')", "float('-inf')"])
def test_commands_that_are_no_numbers_are_zero(run_node: RunNode, value: str) -> None:
    recording = drive(run_node, value)

    assert len(recording.published) == 9
    assert np.ptp(recording.truth.x) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("value", ["1e308", "-1e308", "5e-324", "-0.0"])
def test_extreme_commands_keep_the_robot_within_its_limits(run_node: RunNode, value: str) -> None:
    recording = drive(run_node, value)

    assert recording.outcome.completed
    assert np.isfinite(recording.truth.x).all()
    assert np.abs(recording.truth.v).max() <= recording.scenario.robot.max_linear + 1e-6


def test_stamped_commands_are_not_understood(run_node: RunNode) -> None:
    recording = drive(run_node, "0.2, stamped=True")

    assert {message.type for message in recording.published} == {TWIST_STAMPED}
    assert len(recording.twists().t) == 0
    assert np.ptp(recording.truth.x) == pytest.approx(0.0, abs=1e-9)


def test_unless_the_robot_takes_them(run_node: RunNode) -> None:
    recording = drive(run_node, "0.2, stamped=True", stamped=True)

    assert recording.truth.v.max() == pytest.approx(0.2, abs=1e-3)


def test_text_on_the_command_topic_is_ignored(run_node: RunNode) -> None:
    recording = run_node("""
        class Shouting(Node):
            def __init__(self):
                super().__init__('shouting')
                publisher = self.create_publisher(String, '/cmd_vel', 10)
                self.create_timer(0.1, lambda: publisher.publish(String(data='go' * 24)))
        rclpy.init(); rclpy.spin(Shouting())
    """)

    assert recording.outcome.completed
    assert len(recording.of("/cmd_vel")) == 19
    assert len(recording.twists().t) == 0
    assert np.ptp(recording.truth.x) == pytest.approx(0.0, abs=1e-9)


def test_the_robot_rolls_on_when_its_node_is_gone(run_node: RunNode) -> None:
    recording = run_node(
        """
        class Mortal(Echo):
            def on_scan(self, scan):
                twist = Twist(); twist.linear.x = 0.5
                self.publisher.publish(twist)
                if self.get_clock().now().nanoseconds % 10**12 > 10**9:
                    raise RuntimeError('enough')
        rclpy.init(); rclpy.spin(Mortal())
        """,
        short(5.0),
    )

    outcome, truth = recording.outcome, recording.truth
    assert outcome.kind == "exception"
    assert recording.duration_s == pytest.approx(outcome.at + 1.0)
    rolled_on = truth.x[-1] - np.interp(outcome.at, truth.t / 1e9, truth.x)
    assert rolled_on > 0.2
    assert recording.delivered[-1].time / 1e9 <= outcome.at


def test_the_aftermath_ends_with_the_scenario(run_node: RunNode) -> None:
    recording = run_node("rclpy.init(); Echo()", short(0.5))

    assert recording.outcome.kind == "returned"
    assert recording.duration_s == 0.5


@pytest.mark.parametrize("duration", [0.1, 0.003])
def test_short_scenarios_end(run_node: RunNode, duration: float) -> None:
    recording = run_node("rclpy.init(); rclpy.spin(Echo())", short(duration))

    assert recording.outcome.completed
    assert recording.duration_s == duration


def test_an_unreadable_file_is_not_run(nursery: object, tmp_path: Path) -> None:
    submission = Submission(tmp_path / "absent.py", "the file is empty")
    recording = run_trial(submission, short(1.0), nursery)  # type: ignore[arg-type]

    assert (recording.outcome.kind, recording.outcome.text) == ("unreadable", "the file is empty")
    assert recording.messages == ()
    assert len(recording.twists().t) == len(recording.odometry().t) == len(recording.goals().t) == 0


def test_goals_reach_the_node_reliably(run_node: RunNode) -> None:
    scenario = msgspec.structs.replace(
        short(1.0, "demo_open"),
        script=(ScriptEvent(at=0.25, goal=(1.0, -2.0, 0.0)),),
    )
    recording = run_node(
        """
        from geometry_msgs.msg import PoseStamped
        rclpy.init(); node = Node('listener')
        node.create_subscription(PoseStamped, 'goal_pose',
            lambda goal: print(goal.pose.position.x, goal.pose.position.y), 10)
        rclpy.spin(node)
        """,
        scenario,
    )

    assert [(line.time, line.text) for line in recording.log] == [(250_000_000, "1.0 -2.0")]
    assert (recording.goals().x, recording.goals().y) == ([1.0], [-2.0])


# --- the same again ------------------------------------------------------------------------------


def test_the_digest_does_not_depend_on_the_folder(
    run_node: RunNode, monkeypatch: pytest.MonkeyPatch
) -> None:
    source = """
        class Talking(Echo):
            def on_scan(self, scan):
                print(__file__)
                super().on_scan(scan)
        rclpy.init(); rclpy.spin(Talking())
    """
    first = run_node(source)
    with tempfile.TemporaryDirectory(prefix="a-much-longer-name-of-a-folder-") as elsewhere:
        os.chmod(elsewhere, 0o755)
        monkeypatch.setattr("tempfile.tempdir", elsewhere)
        second = run_node(source)

    assert first.digest() == second.digest()
    assert {line.text for line in first.log + second.log} == {"node.py"}


def test_the_digest_depends_on_what_was_said(run_node: RunNode) -> None:
    digests = [drive(run_node, value).digest() for value in ("0.1", "0.1", "0.10000001")]

    assert digests[0] == digests[1] != digests[2]


def test_the_digest_depends_on_the_seed(run_node: RunNode) -> None:
    assert drive(run_node, "0.1", seed=1).digest() != drive(run_node, "0.1", seed=2).digest()


def test_random_numbers_are_the_same_again(run_node: RunNode) -> None:
    source = "import random; print(random.random(), hash('x')); rclpy.init(); rclpy.spin(Echo())"
    assert run_node(source, short(0.1)).log == run_node(source, short(0.1)).log


# --- real nodes that misbehave -------------------------------------------------------------------

PATIENT = Limits(start=60.0, step=60.0, total=120.0)
FLOODS = {
    "20,000 messages at once": "for _ in range(20_000): self.publisher.publish(Twist())",
    "a message of 10 MB": "self.text.publish(String(data='x' * 10_000_000))",
    "many messages of 1 MB": "for _ in range(6): self.text.publish(String(data='x' * 1_000_000))",
}


@pytest.mark.parametrize("flood", FLOODS)
def test_floods_end_the_trial(run_node: RunNode, flood: str) -> None:
    recording = run_node(f"""
        class Flooding(Echo):
            def __init__(self):
                super().__init__()
                self.text = self.create_publisher(String, '/text', 10)
            def on_scan(self, scan):
                {FLOODS[flood]}
        rclpy.init(); rclpy.spin(Flooding())
    """, limits=PATIENT)  # fmt: skip

    assert recording.outcome.kind == "flooded"
    assert recording.outcome.at < 0.2


def test_a_flood_at_start_up_ends_the_trial(run_node: RunNode) -> None:
    recording = run_node("""
        rclpy.init(); node = Echo()
        for _ in range(6_000): node.publisher.publish(Twist())
        rclpy.spin(node)
    """)

    assert (recording.outcome.kind, recording.outcome.at) == ("flooded", 0.0)


def test_a_slow_flood_ends_the_trial(run_node: RunNode, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tape, "MAX_BYTES", 10_000)
    recording = run_node("rclpy.init(); rclpy.spin(Echo())", short(10.0))

    assert recording.outcome.kind == "flooded"
    assert 0 < len(recording.published) < 60


def test_a_thousand_messages_at_once_are_no_flood(run_node: RunNode) -> None:
    recording = run_node("""
        class Busy(Echo):
            def on_scan(self, scan):
                for _ in range(1_000): self.publisher.publish(Twist())
        rclpy.init(); rclpy.spin(Busy())
    """, short(0.5))  # fmt: skip

    assert recording.outcome.completed
    assert len(recording.published) == 5_000


ATTACKS = {
    "writes garbage": "for fd in range(3, 21): write(fd, b'garbage' * 100)",
    "writes half a length": "for fd in range(3, 21): write(fd, b'x')",
    "writes large lengths": "for fd in range(3, 21): write(fd, bytes([255] * 4))",
    "writes empty frames": "for fd in range(3, 21): write(fd, bytes(4))",
    "closes everything": "os.closerange(0, 50)",
    "closes everything and goes on for ever": "os.closerange(0, 50)\n"
    + " " * 16
    + "while True: pass",
    "closes its output": "os.closerange(1, 3)",
    "turns the link round": "for fd in range(4, 21): dup2(3, fd)",
    "stops itself": "os.kill(os.getpid(), 19)",
    "kills itself": "os.kill(os.getpid(), 9)",
    "kills its parent": "kill(os.getppid(), 9)",
    "leaves at once": "os._exit(0)",
}
ENDS = {"forged", "died", "hung", "exception"}


@pytest.mark.parametrize("attack", ATTACKS)
def test_attacks_on_the_link_end_the_trial(run_node: RunNode, attack: str) -> None:
    if attack == "kills its parent" and os.getuid() != 0:
        pytest.skip("needs the nursery to be another user's")
    harmless = attack in ("closes its output", "kills its parent")
    recording = run_node(
        f"""
        def attempt(call):
            def quiet(*arguments):
                try: call(*arguments)
                except OSError: pass
            return quiet
        write, dup2, kill = attempt(os.write), attempt(os.dup2), attempt(os.kill)
        class Hostile(Echo):
            def on_scan(self, scan):
                {ATTACKS[attack]}
                super().on_scan(scan)
        rclpy.init(); rclpy.spin(Hostile())
        """,
        limits=PATIENT if harmless else Limits(start=20.0, step=1.0, total=30.0),
    )

    assert recording.outcome.completed if harmless else recording.outcome.kind in ENDS
    assert all(message.type == TWIST for message in recording.published)


def test_the_next_trial_knows_nothing_of_an_attack(run_node: RunNode) -> None:
    source = "rclpy.init(); rclpy.spin(Echo())"
    before = run_node(source).digest()
    run_node("for fd in range(3, 21):\n    try: os.write(fd, b'x' * 99)\n    except OSError: pass")

    assert run_node(source).digest() == before


def test_forged_time_marks_do_not_disturb_the_log(run_node: RunNode) -> None:
    recording = run_node("""
        print('\\x1e' + '9' * 19); print('\\x1e²'); print('\\x1e-5'); print('after')
        rclpy.init(); rclpy.spin(Echo())
    """)

    assert recording.outcome.completed
    assert [line.time for line in recording.log] == [0] * 4


def test_an_exception_may_say_what_utf8_can_not(run_node: RunNode) -> None:
    outcome = run_node("raise ValueError(os.fsdecode(b'caf\\xe9'))").outcome

    assert outcome.kind == "exception"
    assert outcome.text.startswith("ValueError: caf?")


def test_tracebacks_show_no_frames_of_the_grader(run_node: RunNode) -> None:
    """Not even of those functions of ours that stand between the student's and rclpy's."""
    outcome = run_node("""
        try:
            rclpy.init(args=['--ros-args', '-p', 'not a parameter'])
        except Exception as error:
            raise ValueError('first') from error
    """).outcome

    assert outcome.kind == "exception"
    assert outcome.detail.count("Traceback (most recent call last)") == 2
    assert "rclpy/context.py" in outcome.detail
    assert "grader/host" not in outcome.detail


@pytest.mark.parametrize("error", ["KeyboardInterrupt()", "GeneratorExit()", "BaseException('b')"])
def test_whatever_is_raised_is_an_exception(run_node: RunNode, error: str) -> None:
    assert run_node(f"raise {error}").outcome.kind == "exception"


def test_a_node_can_not_write_into_the_bags_own_topics(run_node: RunNode) -> None:
    recording = run_node("""
        rclpy.init(); node = Echo()
        for topic in ('/course/trial', '/ground_truth/odom', '/odom', '/goal_pose'):
            node.create_publisher(String, topic, 10).publish(String(data='mine'))
        rclpy.spin(node)
    """)

    topics = {message.topic for message in recording.published} - {"/cmd_vel"}
    assert topics == {
        "/from_node/course/trial",
        "/from_node/ground_truth/odom",
        "/from_node/odom",
        "/from_node/goal_pose",
    }


# --- hosts that forge ----------------------------------------------------------------------------


class FakeNursery:
    """Gives out one host that the test plays."""

    def __init__(self, *answers: bytes, hang_up: bool = True) -> None:
        self._answers, self._hang_up = answers, hang_up

    @contextmanager
    def host(self, folder: Path) -> Iterator[FakeHost]:
        with FakeHost(self._answers, hang_up=self._hang_up) as host:
            yield host


@pytest.fixture
def forge(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):  # type: ignore[no-untyped-def]
    """Run a trial in which the host gives these answers, one after the other."""
    monkeypatch.setattr(link, "STACK_TIME", 0.1)
    monkeypatch.setattr(trial, "GRACE", 0.01)
    file = tmp_path / "node.py"
    file.write_text("pass")

    def run(*answers: bytes, hang_up: bool = True, step: float = 20.0) -> Recording:
        nursery = FakeNursery(*answers, hang_up=hang_up)
        limits = Limits(start=20.0, step=step, total=30.0)
        return run_trial(Submission(file), short(1.0), nursery, limits=limits)  # type: ignore[arg-type]

    return run


SCANS = [13_000_000 + i * 100_000_000 for i in range(10)]  # [ns] when the lidar of `short` sends
FIRST = SCANS[0]
GO = Published(FIRST, "/cmd_vel", TWIST, twist(time=0, linear_x=0.5).data)


def test_an_honest_fake_host_completes(forge) -> None:  # type: ignore[no-untyped-def]
    recording = forge(settled(), *(settled(time) for time in (*SCANS, 10**9)))

    assert recording.outcome.completed
    assert [message.time for message in recording.of("/scan")] == SCANS


TIMES = {
    "not the start": [settled(1)],
    "back in time": [settled(), settled(FIRST), settled(0)],
    "standing still": [settled(), settled(0)],
    "ahead of time": [settled(), settled(10**9)],
    "the end of time": [settled(), settled(2**62)],
    "a message from the future": [settled(), settled(FIRST, published=[
        Published(FIRST + 1, "/cmd_vel", TWIST, b"")])],
    "a message from the past": [settled(), settled(FIRST), settled(SCANS[1], published=[
        Published(FIRST - 1, "/cmd_vel", TWIST, b"")])],
    "messages in disorder": [settled(), settled(FIRST, published=[
        GO, Published(FIRST - 1, "/cmd_vel", TWIST, b"")])],
    "an end in the future": [settled(), encode(Ended(10**9, "returned", "", "", []))],
    "an end in the past": [settled(), settled(FIRST), encode(Ended(0, "returned", "", "", []))],
    "early for ever": [encode(Slept(10**9))],
    "early in the middle": [settled(), encode(Slept(10**9))],
    "two answers": [settled() + settled(FIRST)],
    "another kind of end": [frame({"type": "ended", "now": 0, "kind": "completed", "text": "",
                                   "detail": "", "published": []})],
}  # fmt: skip


@pytest.mark.parametrize("what", TIMES)
def test_impossible_times_are_forged(forge, what: str) -> None:  # type: ignore[no-untyped-def]
    recording = forge(*TIMES[what], hang_up=False)

    assert recording.outcome.kind == "forged"
    assert "\n" not in recording.outcome.text
    assert recording.duration_s <= 1.0


def test_a_host_that_hangs_up_is_dead(forge) -> None:  # type: ignore[no-untyped-def]
    outcome = forge(settled(), settled(FIRST)).outcome

    assert (outcome.kind, outcome.text) == (
        "died",
        "the node's process ended by itself (signal 9)",
    )


def test_a_host_that_says_nothing_hangs(forge) -> None:  # type: ignore[no-untyped-def]
    outcome = forge(settled(), hang_up=False, step=0.05).outcome

    assert (outcome.kind, outcome.detail) == ("hung", '  File "agent.py", line 7 in on_scan')


def test_a_forged_flood_is_a_flood(forge, monkeypatch) -> None:  # type: ignore[no-untyped-def]
    monkeypatch.setattr(tape, "MAX_BYTES", 1_000_000)
    long = Published(FIRST, "/" * MAX_NAME, "x" * MAX_NAME, b"")
    outcome = forge(
        settled(), settled(FIRST, published=[long] * MAX_PUBLISHED), hang_up=False
    ).outcome

    assert outcome.kind == "flooded"


def test_endpoints_without_end_are_a_flood(forge) -> None:  # type: ignore[no-untyped-def]
    many = [EndpointReport("client", "/n", "/t", "x/srv/Y")] * 500
    answers = [settled(time, endpoints=many) for time in (0, *SCANS[:2])]

    assert forge(*answers, hang_up=False).outcome.kind == "flooded"


ODD = ["", "cmd_vel", "/\x00", "/a\nb", "/[bold]x[/]", "/\x1b[31m", "/ü" * 100, "/cmd_vel\u202e"]


@pytest.mark.parametrize("name", ODD)
def test_odd_names_are_just_names(forge, name: str) -> None:  # type: ignore[no-untyped-def]
    odd = Published(FIRST, name, name, b"\xff" * 52)
    recording = forge(settled(), settled(FIRST, published=[odd]))

    assert [(m.topic, m.type) for m in recording.published] == [(name, name)]
    assert recording.outcome.kind == "died"


@pytest.mark.parametrize("data", [b"", b"\0\1\0\0", b"\xff" * 52, b"\0\1\0\0" + b"\xff" * 48])
def test_broken_commands_do_not_move_the_robot(forge, data: bytes) -> None:  # type: ignore[no-untyped-def]
    broken = Published(FIRST, "/cmd_vel", TWIST, data)
    answers = [settled(), settled(FIRST, published=[broken])]
    recording = forge(*answers, *(settled(time) for time in (*SCANS[1:], 10**9)))

    assert recording.outcome.completed
    assert np.ptp(recording.truth.x) == pytest.approx(0.0, abs=1e-9)


def test_a_scan_of_the_nodes_own_is_not_the_robots(forge) -> None:  # type: ignore[no-untyped-def]
    own = Published(FIRST, "/scan", LASER_SCAN, b"")
    recording = forge(settled(), settled(FIRST, published=[own]))

    assert len(recording.scans()) == len(recording.of("/scan"))
    assert recording.published[0].topic == "/from_node/scan"


def test_the_fixture_is_what_the_tests_assume(short_scenario: Scenario) -> None:
    assert short_scenario.lidar.phase == FIRST / 1e9
    assert short(1.0).odometry.enabled is False


@pytest.mark.parametrize("size", [0, 1_000])
def test_a_full_folder_ends_the_trial(
    run_node: RunNode, monkeypatch: pytest.MonkeyPatch, size: int
) -> None:
    monkeypatch.setattr(tape, "MAX_FILES", 50)
    monkeypatch.setattr(tape, "MAX_FOLDER", 20_000)
    monkeypatch.setattr(trial, "LOOK_EVERY", 1)
    recording = run_node(f"""
        class Hoarder(Echo):
            def on_scan(self, scan):
                self.count = getattr(self, 'count', 0) + 1
                for i in range(10):
                    open(f'{{self.count}}_{{i}}', 'w').write('x' * {size})
        rclpy.init(); rclpy.spin(Hoarder())
    """)

    assert recording.outcome.kind == "flooded"
    assert "files" in recording.outcome.text
    assert 0.1 < recording.outcome.at < 1.0
