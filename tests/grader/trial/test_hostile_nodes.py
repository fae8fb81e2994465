"""Real nodes that misbehave while they run: floods, and attacks on the link to the judge."""

import os

import pytest
from node_runs import RunNode, short

from grader.trial import recorder
from grader.trial.virtual_time import Limits
from sim.messages import TWIST

PATIENT = Limits(start=60.0, step=60.0, total=120.0)
FLOODS = {
    "1,000 messages": ("completed", "for _ in range(1_000): self.publisher.publish(Twist())"),
    "20,000 messages": ("flooded", "for _ in range(20_000): self.publisher.publish(Twist())"),
    "10 MB": ("flooded", "self.text.publish(String(data='x' * 10_000_000))"),
    "6 MB": ("flooded", "for _ in range(6): self.text.publish(String(data='x' * 1_000_000))"),
}


@pytest.mark.parametrize("flood", FLOODS)
def test_floods_end_the_trial(run_node: RunNode, flood: str) -> None:
    kind, body = FLOODS[flood]
    recording = run_node(f"""
        class Flooding(Echo):
            def __init__(self):
                super().__init__()
                self.text = self.create_publisher(String, '/text', 10)
            def on_scan(self, scan):
                {body}
        rclpy.init(); rclpy.spin(Flooding())
    """, short(0.2), limits=PATIENT)  # fmt: skip

    assert recording.outcome.kind == kind
    assert ("messages as large as images" in recording.outcome.text) == flood.endswith("MB")


@pytest.mark.parametrize("most, published", [(50, 10**6), (10**6, 10_000)])  # messages, bytes
def test_a_slow_flood_ends_the_trial(
    run_node: RunNode, most: int, published: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(recorder, "MAX_MESSAGES", most)
    limits = Limits(published=published)
    recording = run_node("rclpy.init(); rclpy.spin(Echo())", short(10.0), limits=limits)

    assert recording.outcome.kind == "flooded"
    assert 0 < len(recording.published) < 60


def test_a_start_up_has_one_limit_however_often_it_asks(run_node: RunNode) -> None:
    recording = run_node(
        """
        import ctypes
        from grader.hosted.questions import Question, ask
        while True:
            ask(Question('load', 'model.pkl'))
            ctypes.CDLL(None).usleep(100_000)
        """,
        limits=Limits(start=1.0),
    )

    assert recording.outcome.kind == "hung"


ATTACKS = {
    "writes garbage": "for fd in range(3, 21): write(fd, b'garbage' * 100)",
    "writes large lengths": "for fd in range(3, 21): write(fd, bytes([255] * 4))",
    "closes everything": "os.closerange(0, 50)",
    "closes everything and goes on for ever": "os.closerange(0, 50)\n"
    + " " * 16
    + "while True: pass",
    "closes its output": "os.closerange(1, 3)",
    "turns the link round": "for fd in range(4, 21): dup2(3, fd)",
    "kills itself": "os.kill(os.getpid(), 9)",
    "kills its parent": "kill(os.getppid(), 9)",
}
ENDS = {"forged", "died", "hung", "exception"}


@pytest.mark.parametrize("attack", ATTACKS)
def test_attacks_on_the_link_end_the_trial(run_node: RunNode, attack: str) -> None:
    if attack == "kills its parent" and os.getuid() != 0:
        pytest.skip("needs the forkserver to be another user's")
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


def test_a_node_can_not_write_into_the_bags_own_topics(run_node: RunNode) -> None:
    recording = run_node("""
        rclpy.init(); node = Echo()
        for topic in ('/course/trial', '/ground_truth/odom', '/odom', '/goal_pose'):
            publisher = node.create_publisher(String, topic, 10)
            node.create_timer(0.1, lambda p=publisher: p.publish(String(data='mine')))
        rclpy.spin(node)
    """)

    topics = {message.topic for message in recording.published} - {"/cmd_vel"}
    assert topics == {
        "/from_node/course/trial",
        "/from_node/ground_truth/odom",
        "/from_node/odom",
        "/from_node/goal_pose",
    }
