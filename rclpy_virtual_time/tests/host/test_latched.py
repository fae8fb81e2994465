"""Subscriptions that come late and ask for what was said before (transient local)."""

from rclpy.serialization import deserialize_message
from std_msgs.msg import String

from rclpy_virtual_time.tests.runs import RunNode

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


def test_a_late_subscription_hears_all_of_it_at_once_in_every_run(run_node: RunNode) -> None:
    """DDS brings a history from a thread of its own, some real time later."""
    said = []
    for _ in range(2):
        heard = [m for m in run_node(LATE, 0.22).published if m.topic == "/heard"]
        said.append([(m.time, deserialize_message(m.data, String).data) for m in heard])
    right = [(50_000_000 * (k + 1), f"{k} {number}") for k in range(4) for number in range(1, 4)]
    assert said == [right, right]
