"""Subscriptions that come late and ask for what was said before (transient local)."""

from pathlib import Path

from grader.course.submission import Submission
from grader.drive import scenario_for
from grader.trial.virtual_time import run_trial
from rclpy_virtual_time.link.hosts import ForkServer
from sim.messages import decode

LATE = """
import rclpy
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import String

LATCHED = QoSProfile(depth=3, durability=DurabilityPolicy.TRANSIENT_LOCAL)

rclpy.init()
node = rclpy.create_node("late")
publisher = node.create_publisher(String, "/latched", LATCHED)
heard = node.create_publisher(String, "/heard", 10)
for number in range(4):
    publisher.publish(String(data=str(number)))
subscriptions = []


def subscribe():
    name = len(subscriptions)
    subscriptions.append(node.create_subscription(
        String, "/latched", lambda m: heard.publish(String(data=f"{name} {m.data}")), LATCHED
    ))


node.create_timer(0.05, subscribe)
rclpy.spin(node)
"""


def test_a_late_subscription_hears_all_of_it_at_once_in_every_run(
    tmp_path: Path, forkserver: ForkServer
) -> None:
    """DDS brings a history from a thread of its own, some real time later."""
    file = tmp_path / "late.py"
    file.write_text(LATE, "utf-8")
    said = []
    for _ in range(2):
        recording = run_trial(
            Submission(file), scenario_for("demo_wall", duration=0.22), forkserver
        )
        heard = [m for m in recording.published if m.topic == "/heard"]
        said.append([(m.time, decode(m.data, m.type).data) for m in heard])
    right = [(50_000_000 * (k + 1), f"{k} {number}") for k in range(4) for number in range(1, 4)]
    assert said == [right, right]
