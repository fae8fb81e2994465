"""One trial: what the robot makes of what comes out of a host, and that it is the same again."""

import textwrap
from pathlib import Path

import numpy as np
import pytest
from msgspec.structs import replace
from node_runs import RunNode, short

from grader.course.submission import Submission
from grader.recording import COMPLETED, Recording
from grader.trial import virtual_time as trial_module
from grader.trial.virtual_time import Limits, run_trial
from rclpy_virtual_time.link import exchange, pipes
from sim.messages import TWIST_STAMPED
from sim.scenario import OdometrySpec, ProgramSpec

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

COMMANDS = {  # how fast [m/s] they make the robot
    "0.2": 0.2,
    "0.2, stamped=True": 0.0,  # a type that it doesn't take
    "float('nan')": 0.0,
    "float('-inf')": 0.0,
    "1e308": 0.5,
    "-1e308": 0.5,
    "5e-324": 0.0,
}


@pytest.mark.parametrize("command", COMMANDS)
def test_the_robot_follows_its_commands_within_its_limits(run_node: RunNode, command: str) -> None:
    recording = drive(run_node, command)

    assert recording.outcome.completed
    assert len(recording.published) == 9
    assert np.isfinite(recording.truth.x).all()
    assert np.abs(recording.truth.v).max() == pytest.approx(COMMANDS[command], abs=1e-3)


def test_a_robot_may_take_stamped_commands(run_node: RunNode) -> None:
    recording = drive(run_node, "0.2, stamped=True", stamped=True)

    assert {message.type for message in recording.published} == {TWIST_STAMPED}
    assert recording.truth.v.max() == pytest.approx(0.2, abs=1e-3)


def test_what_nobody_listens_to_costs_no_turn_until_somebody_does(run_node: RunNode) -> None:
    scenario = replace(short(1.0), odometry=OdometrySpec(rate=50.0))
    recording = run_node(
        """
        from nav_msgs.msg import Odometry
        class Late(Echo):
            def listen(self):
                self.create_subscription(Odometry, '/odom', self.on_odom, 10)
                print('listening from', self.get_clock().now().nanoseconds % 10**12 // 10**5)
            def on_odom(self, odom):
                print('odom', odom.header.stamp.nanosec // 10**5)
        rclpy.init()
        node = Late()
        node.create_timer(0.5137, node.listen)
        rclpy.spin(node)
        """,
        scenario,
    )
    said = [line.text.split() for line in recording.log]
    begun = int(said[0][-1])
    sent = [message.time // 10**5 for message in recording.of("/odom")]
    turns = np.rint(recording.compute.time * 1e4)
    assert recording.outcome.completed
    assert [int(line[1]) for line in said[1:]] == [time for time in sent if time > begun]
    assert begun in turns
    assert not {time for time in sent if time < begun} & {*turns}


def test_a_node_that_listens_to_nothing_may_publish_images(run_node: RunNode) -> None:
    recording = run_node(
        """
        rclpy.init()
        node = Node('camera')
        publisher = node.create_publisher(String, '/image', 10)
        node.create_timer(0.1, lambda: publisher.publish(String(data='x' * 640 * 480 * 3)))
        rclpy.spin(node)
        """,
        short(1.0),
    )
    assert (recording.outcome.kind, len(recording.published)) == (COMPLETED, 9)
    assert len(recording.of("/scan")) == 10


def test_what_nobody_listened_to_is_known_up_to_a_node_s_end(run_node: RunNode) -> None:
    brief = "rclpy.init(); node = Node('brief'); node.create_timer(0.55, exit); rclpy.spin(node)"
    recording = run_node(brief, short(1.0))
    assert (recording.outcome.kind, len(recording.of("/scan"))) == ("exited", 6)


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


@pytest.mark.parametrize(
    ("source", "duration", "kind"),
    [("rclpy.spin(Echo())", 0.003, "completed"), ("Echo()", 0.5, "returned")],
)
def test_short_scenarios_end(run_node: RunNode, source: str, duration: float, kind: str) -> None:
    recording = run_node(f"rclpy.init(); {source}", short(duration))

    assert (recording.outcome.kind, recording.duration_s) == (kind, duration)


def test_an_unreadable_file_is_not_run(forkserver: object, tmp_path: Path) -> None:
    submission = Submission(tmp_path / "absent.py", "the file is empty")
    recording = run_trial(submission, short(1.0), forkserver)  # type: ignore[arg-type]

    assert (recording.outcome.kind, recording.outcome.text) == ("unreadable", "the file is empty")
    assert recording.messages == ()
    assert len(recording.twists().t) == len(recording.odometry().t) == len(recording.goals().t) == 0


def test_a_missing_file_is_named(forkserver: object, tmp_path: Path) -> None:
    scenario = replace(short(1.0), program=(ProgramSpec("client.py"),))
    (tmp_path / "server.py").write_text("")
    server = Submission(tmp_path / "server.py")
    outcome = run_trial(server, scenario, forkserver).outcome  # type: ignore[arg-type]

    said = "there is no client.py in the submission, only server.py"
    assert (outcome.kind, outcome.text) == ("missing", said)


CALL = "lambda scan: node.create_client(Trigger, 'ask').call(Trigger.Request())"
STUCK = f"""
from std_srvs.srv import Trigger
rclpy.init(); node = Node('blocks'); node.create_subscription(LaserScan, '/scan', {CALL}, 10)
rclpy.spin(node)
"""


@pytest.mark.parametrize(
    ("source", "kind", "said"),
    [
        ("rclpy.init(); os._exit(5)", "died", "exit code 5"),
        ("rclpy.init(); Node('mute'); threading.Event().wait()", "never_spun", "never spins"),
        (STUCK, "stuck", "call()"),
    ],
)
def test_each_end_has_a_name(source: str, kind: str, said: str, run_node: RunNode) -> None:
    """Those that a host doesn't say itself: rclpy_virtual_time/tests/host/test_host_ends.py."""
    outcome = run_node(source).outcome
    assert (outcome.kind, said in outcome.text + outcome.detail) == (kind, True), outcome


# --- the same again ------------------------------------------------------------------------------


def test_the_digest_depends_on_what_was_said_and_on_the_seed(run_node: RunNode) -> None:
    chance = "0.1 + 1e-3 * __import__('random').random() + 1e-9 * (hash('x') % 1000)"
    first, again, said, seed = (
        drive(run_node, value, seed=seed).digest()
        for value, seed in ((chance, 1), (chance, 1), ("0.1", 1), ("0.1", 2))
    )

    assert first == again
    assert len({first, said, seed}) == 3


def test_a_trial_that_takes_too_long_says_so(run_node: RunNode) -> None:
    outcome = drive(run_node, "0.3", limits=NO_TIME).outcome

    assert (outcome.kind, "were not done after 0 s" in outcome.text) == ("slow", True)


def test_what_a_busy_machine_keeps_from_a_trial_does_not_count(
    run_node: RunNode, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(trial_module, "BUSY", 1e9)
    monkeypatch.setattr(pipes, "UNEXPLAINED", -1.0)
    monkeypatch.setattr(exchange, "UNEXPLAINED", -1.0)
    monkeypatch.setattr(pipes.Pipes, "_queued", lambda _: 1e3)

    assert drive(run_node, "0.3", limits=NO_TIME).outcome.completed


def test_time_without_an_event_goes_by_in_slices(run_node: RunNode) -> None:
    """A machine that needs seconds for a minute of timers is not taken for a node that hangs."""
    scenario = short(5.0)
    scenario = replace(scenario, lidar=replace(scenario.lidar, rate=0.1))
    source = """
        rclpy.init()
        node = rclpy.create_node("timers")
        node.create_timer(0.5, lambda: None)
        rclpy.spin(node)
    """
    recording = run_node(textwrap.dedent(source), scenario)
    assert recording.outcome.completed
    frames = np.append(recording.compute.time, scenario.duration)
    assert np.diff(frames).max() < 1.0  # [s]
