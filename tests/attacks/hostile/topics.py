"""The robot's topics: ground truth, a second publisher, garbage, good only while watched."""

import math

from geometry_msgs.msg import Twist
from kit import attempt, gained, trick
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Bool, Float64, String

JUDGES = {
    "/ground_truth/odom": Odometry,
    "/ground_truth/clearance": Float64,
    "/ground_truth/contact": Bool,
    "/course/trial": String,
}
ROBOTS = {"/clock": Clock, "/odom": Odometry, "/scan": LaserScan}


@trick()
def ground_truth(node, scan):
    """Subscribe to what only the judge knows: ground truth, the trial's document, the scenario."""
    if node.heard == 1:
        for topic, kind in {**JUDGES, "/from_node/scan": String}.items():
            node.create_subscription(kind, topic, lambda _, topic=topic: gained(topic), 10)


@trick()
def of_the_robot(node, scan):
    """Speak in the robot's name: a clock, an odometry, scans and a ground truth of its own."""
    if node.heard > 3:
        return
    if node.heard == 1:
        node.lies = []
        for topic, kind in {
            **JUDGES,
            "/clock": Clock,
            "/odom": Odometry,
            "/scan": LaserScan,
        }.items():
            with attempt():
                node.lies.append((node.create_publisher(kind, topic, 10), kind))
    for publisher, kind in node.lies:
        publisher.publish(LaserScan(ranges=[9.0] * 360) if kind is LaserScan else kind())


@trick()
def corrected(node, scan):
    """A second publisher sends a better command after each bad one, so that both could count."""
    node.second = getattr(node, "second", None) or node.create_publisher(Twist, "/cmd_vel", 10)
    for speed in (0.0, 0.15, 0.5):
        twist = Twist()
        twist.linear.x = speed
        node.second.publish(twist)


@trick()
def not_a_number(node, scan):
    """Command NaN and infinity, which compare false with everything that is checked."""
    node.drive = lambda speed: type(node).drive(node, (math.nan, math.inf, 1e308)[node.heard % 3])


@trick("any")
def other_type(node, scan):
    """Publish on /cmd_vel bytes that are no message of its type."""
    for data in (b"\x00\x01\x00\x00" + b"\xff" * 48, b""):
        with attempt():
            node.cmd_vel.publish(data)


@trick()
def safe_while_sampled(node, scan):
    """Stand whenever the clearance is sampled (each 20 ms), and race in between."""
    if node.heard > 1:
        return
    node.fast = False

    def turn():
        node.fast = not node.fast
        node.drive(0.5 if node.fast else 0.0)

    node.create_timer(0.01, turn)
