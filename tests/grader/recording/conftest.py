"""One recording for all tests of bags."""

from pathlib import Path

import msgspec
import pytest

from grader.course.submission import Submission
from grader.recording import Recording, bag
from grader.trial.virtual_time import run_trial
from rclpy_virtual_time.link.hosts import ForkServer
from sim.scenario import ScriptEvent
from sim.scenario_files import load_scenario

NODE = """
import rclpy, sys
from rclpy.node import Node
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from sensor_msgs.msg import LaserScan
from std_msgs.msg import String
rclpy.init()
node = Node('wanderer')
drive = node.create_publisher(Twist, '/cmd_vel', 10)
tell = node.create_publisher(String, 'said', 10)
def on_scan(scan):
    twist = Twist(); twist.linear.x, twist.angular.z = 0.3, 0.7
    drive.publish(twist)
    tell.publish(String(data='grüß ' + str(scan.header.stamp.nanosec)))
    node.get_logger().info('scan')
    print('line \\x00 \\x1b[31m', file=sys.stderr)
node.create_subscription(LaserScan, '/scan', on_scan, 10)
node.create_subscription(Odometry, '/odom', lambda _: None, 10)
rclpy.spin(node)
"""


@pytest.fixture(scope="module")
def recording(forkserver: ForkServer, tmp_path_factory: pytest.TempPathFactory) -> Recording:
    file = tmp_path_factory.mktemp("node") / "wanderer.py"
    file.write_text(NODE, "utf-8")
    scenario = msgspec.structs.replace(
        load_scenario("avoid_store"),
        duration=1.5,
        script=(ScriptEvent(at=0.4, goal=(1.0, 2.0, 30.0)),),
    )
    recording = run_trial(Submission(file), scenario, forkserver)
    assert recording.outcome.completed
    assert len(recording.published) >= 20
    return recording


@pytest.fixture
def saved(recording: Recording, tmp_path: Path) -> Path:
    return bag.save(recording, tmp_path / "bag")
