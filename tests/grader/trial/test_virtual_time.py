"""One trial: what the robot makes of what comes out of a host, and that it is the same again."""

import os
import tempfile
import textwrap
from pathlib import Path

import msgspec
import numpy as np
import pytest
from node_runs import RunNode, short

from grader.course.submission import Submission
from grader.link import pipes
from grader.recording import Recording
from grader.trial import virtual_time as trial_module
from grader.trial.virtual_time import Limits, run_trial
from sim.messages import TWIST_STAMPED
from sim.scenario import ScriptEvent

NO_TIME = Limits(total=1e-9)  # [s]
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


def test_an_unreadable_file_is_not_run(forkserver: object, tmp_path: Path) -> None:
    submission = Submission(tmp_path / "absent.py", "the file is empty")
    recording = run_trial(submission, short(1.0), forkserver)  # type: ignore[arg-type]

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


def test_a_trial_that_takes_too_long_says_so(run_node: RunNode) -> None:
    outcome = drive(run_node, "0.3", limits=NO_TIME).outcome

    assert (outcome.kind, "were not done after 0 s" in outcome.text) == ("hung", True)


def test_what_a_busy_machine_keeps_from_a_trial_does_not_count(
    run_node: RunNode, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(trial_module, "BUSY", 1e9)
    monkeypatch.setattr(pipes, "UNEXPLAINED", -1.0)
    monkeypatch.setattr(pipes.Pipes, "_queued", lambda _: 1e3)

    assert drive(run_node, "0.3", limits=NO_TIME).outcome.completed
