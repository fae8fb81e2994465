"""tf2_ros and message_filters in a trial: what the robot says of its frames reaches a node."""

from pathlib import Path

from grader.course.submission import Submission
from grader.drive import scenario_for
from grader.recording import Recording
from grader.trial.virtual_time import run_trial
from rclpy_virtual_time.link.hosts import ForkServer
from sim.messages import TF_MESSAGE, decode

LISTENS = """
import math, threading
import rclpy
from rclpy.duration import Duration
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.time import Time
from nav_msgs.msg import Odometry
from sensor_msgs.msg import LaserScan
from tf2_msgs.msg import TFMessage
from tf2_ros import Buffer, StaticTransformBroadcaster, TransformException, TransformListener
from geometry_msgs.msg import TransformStamped


class Listens(Node):
    def __init__(self):
        super().__init__("listens")
        self.frames = Buffer()
        self.listener = TransformListener(self.frames, self)
        self.create_subscription(LaserScan, "/scan", self.on_scan, 10)
        own = TransformStamped()
        own.header.frame_id, own.child_frame_id = "base_link", "gripper"
        own.transform.translation.x, own.transform.rotation.w = 0.25, 1.0
        self.broadcaster = StaticTransformBroadcaster(self)
        self.broadcaster.sendTransform(own)
        self.late = None

    def on_scan(self, scan):
        stamp = Time.from_msg(scan.header.stamp)
        try:
            lidar = self.frames.lookup_transform("base_link", scan.header.frame_id, Time())
            robot = self.frames.lookup_transform("odom", "gripper", Time())
        except TransformException as error:
            print(type(error).__name__)
            return
        q = lidar.transform.rotation
        yaw = math.degrees(2 * math.atan2(q.z, q.w))
        print(f"{lidar.child_frame_id} {lidar.transform.translation.x:.2f} {yaw:.0f}")
        print(f"gripper {robot.transform.translation.x:.2f}")
        if self.late is None:
            self.late = self.create_subscription(
                TFMessage, "/tf_static", lambda m: print("late", m.transforms[0].child_frame_id),
                self.listener.tf_static_sub.qos_profile,
            )


rclpy.init()
rclpy.spin(Listens())
"""


def listen(tmp_path: Path, forkserver: ForkServer, source: str = LISTENS) -> Recording:
    file = tmp_path / "listens.py"
    file.write_text(source, "utf-8")
    scenario = scenario_for("avoid_field_turned", duration=0.5)
    return run_trial(Submission(file), scenario, forkserver)


def test_a_node_hears_the_robots_transforms(tmp_path: Path, forkserver: ForkServer) -> None:
    recording = listen(tmp_path, forkserver)
    assert recording.outcome.completed, recording.outcome
    said = [line.text for line in recording.log if "[" not in line.text]
    assert said.count("rplidar_link -0.05 -90") == 5
    x = recording.odometry().x[0]
    assert f"gripper {x + 0.25:.2f}" in said
    assert "late rplidar_link" in said
    own = [m for m in recording.published if m.topic == "/from_node/tf_static"]
    assert decode(own[0].data, TF_MESSAGE).transforms[0].child_frame_id == "gripper"


def test_a_scan_and_the_odometry_come_together(tmp_path: Path, forkserver: ForkServer) -> None:
    together = """
import rclpy
from message_filters import ApproximateTimeSynchronizer, Subscriber
from nav_msgs.msg import Odometry
from rclpy.qos import QoSProfile
from sensor_msgs.msg import LaserScan
from tf2_msgs.msg import TFMessage
rclpy.init()
node = rclpy.create_node("together")
late = TFMessage, "/tf_static", lambda _: print("late"), QoSProfile(depth=1, durability=1)
node.create_timer(0.3, lambda: node.create_subscription(*late))
ends = [Subscriber(node, LaserScan, "/scan"), Subscriber(node, Odometry, "/odom", qos_profile=5)]
both = ApproximateTimeSynchronizer(ends, 10, slop=0.1)
both.registerCallback(lambda scan, odom: print("together", len(scan.ranges), odom.child_frame_id))
rclpy.spin(node)
"""
    said = [line.text for line in listen(tmp_path, forkserver, together).log]
    assert [line.rpartition(" ")[2] for line in said if "together" in line] == ["base_link"] * 5
    assert said.count("late") == 1


def test_a_volatile_subscription_does_not_hear_what_was_sent_once(
    tmp_path: Path, forkserver: ForkServer
) -> None:
    deaf = """
import rclpy
from tf2_msgs.msg import TFMessage
rclpy.init()
node = rclpy.create_node("deaf")
node.create_subscription(TFMessage, "/tf_static", lambda message: print("heard it"), 10)
node.create_subscription(TFMessage, "/tf", lambda message: print("moving"), 10)
rclpy.spin(node)
"""
    recording = listen(tmp_path, forkserver, deaf)
    said = [line.text for line in recording.log]
    assert "moving" in said
    assert "heard it" not in said
    (mismatch,) = [e.mismatch for e in recording.endpoints if e.topic == "/tf_static"]
    assert "transient-local" in mismatch


def test_a_lookup_may_wait_in_another_thread(tmp_path: Path, forkserver: ForkServer) -> None:
    waits = """
import rclpy, threading
from rclpy.duration import Duration
from rclpy.time import Time
from tf2_ros import Buffer, TransformListener
rclpy.init()
node = rclpy.create_node("waits")
frames = Buffer()
listener = TransformListener(frames, node, spin_thread=True)
begin = node.get_clock().now()
frames.lookup_transform("base_link", "rplidar_link", Time(), timeout=Duration(seconds=1))
print("found after", (node.get_clock().now() - begin).nanoseconds // 1_000_000, "ms")
threading.Event().wait()
"""
    recording = listen(tmp_path, forkserver, waits)
    assert "found after 10 ms" in [line.text for line in recording.log], recording.log
