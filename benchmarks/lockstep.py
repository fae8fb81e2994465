"""How fast is a trial? Lock-step cost, real-time factor, and a full grading from a cold command.

Every figure stands beside a peer's from the same run, because absolute times differ from machine to
machine: plain rclpy doing the same work in one process without a judge, and a Python that only
imports what a grading needs.
"""

from __future__ import annotations

import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import msgspec
import numpy as np

from grader.course.submission import Submission
from grader.link.hosts import ForkServer
from grader.trial.virtual_time import run_trial
from sim.messages import EPOCH_NS
from sim.scenario import Scenario
from sim.scenario_files import load_scenario

ROOT = Path(__file__).resolve().parent.parent
SOLUTION = ROOT / "solutions/obstacle_avoidance/obstacle_avoidance_agent.py"
RUNS = 5
SECONDS = 60.0  # simulated

ECHO = """
import rclpy
from geometry_msgs.msg import Twist
from rclpy.node import Node
from sensor_msgs.msg import LaserScan

class Echo(Node):
    def __init__(self):
        super().__init__('echo')
        self.publisher = self.create_publisher(Twist, '/cmd_vel', 10)
        self.create_subscription(LaserScan, '/scan', self.on_scan, 10)
    def on_scan(self, scan):
        self.publisher.publish(Twist())
"""
SPIN = "rclpy.init(); rclpy.spin(Echo())"
CONTROL = """
from nav_msgs.msg import Odometry
class Controller(Echo):
    def __init__(self):
        super().__init__()
        self.create_subscription(Odometry, '/odom', lambda _: None, 10)
        self.create_timer(0.1, lambda: self.publisher.publish(Twist()))
    def on_scan(self, scan):
        pass
rclpy.init(); rclpy.spin(Controller())
"""
PLAIN = """
import time
from rclpy.serialization import serialize_message
rclpy.init()
node, robot = Echo(), Node('robot')
speaker = robot.create_publisher(LaserScan, '/scan', 10)
listener = robot.create_subscription(Twist, '/cmd_vel', print, 10, raw=True)
scan = serialize_message(LaserScan(ranges=[1.0] * 360))
def step():
    speaker.publish(scan)
    while (message := listener.handle.take_message(Twist, True)) is None:
        rclpy.spin_once(node, timeout_sec=0)
for _ in range(200): step()
start = time.perf_counter()
for _ in range(2000): step()
print((time.perf_counter() - start) / 2000)
"""


def main() -> None:
    """Print the three figures, each with its peer."""
    with tempfile.TemporaryDirectory() as name, ForkServer(EPOCH_NS) as forkserver:
        folder = Path(name)
        _step_cost(folder, forkserver)
        _real_time_factor(folder, forkserver)
    _cold_grading()


def _scenario(**changes: object) -> Scenario:
    scenario = load_scenario("demo_wall")
    return msgspec.structs.replace(scenario, duration=SECONDS, **changes)


def _node(folder: Path, source: str) -> Submission:
    file = folder / "node.py"
    file.write_text(source)
    return Submission(file)


def _step_cost(folder: Path, forkserver: ForkServer) -> None:
    scenario = load_scenario("demo_wall")
    silent = msgspec.structs.replace(scenario.odometry, enabled=False)
    node = _node(folder, ECHO + SPIN)
    costs = []
    for _ in range(RUNS):
        recording = run_trial(node, _scenario(odometry=silent), forkserver)
        assert len(recording.published) == len(recording.delivered) > 500
        costs.append(float(np.median(recording.compute.wall[2:])))
    plain = [_plain_step(folder, forkserver) for _ in range(RUNS)]
    step, peer = statistics.median(costs), statistics.median(plain)
    print(f"scan -> cmd_vel, lock-step: {step * 1e3:.3f} ms (goal 0.4)")
    print(f"  plain rclpy in one process: {peer * 1e3:.3f} ms; ratio {step / peer:.1f}")


def _plain_step(folder: Path, forkserver: ForkServer) -> float:
    file = folder / "plain.py"
    file.write_text(ECHO + PLAIN)
    environment = {
        **forkserver.ros.variables(),
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "OFF",
        "ROS_LOG_DIR": str(folder),
    }
    done = subprocess.run(
        [sys.executable, str(file)], env=environment, capture_output=True, text=True, check=True
    )
    return float(done.stdout)


def _real_time_factor(folder: Path, forkserver: ForkServer) -> None:
    node = _node(folder, ECHO + CONTROL)
    factors = []
    for _ in range(RUNS):
        start = time.perf_counter()
        recording = run_trial(node, _scenario(), forkserver)
        elapsed = time.perf_counter() - start - recording.compute.wall[0]
        assert recording.outcome.completed
        factors.append(SECONDS / elapsed)
    factor = statistics.median(factors)
    print("real-time factor with 10 Hz x 360 beams, 20 Hz odometry, 10 Hz control:")
    print(f"  {factor:.0f} (goal 100)")
    print("  a live robot: 1")


def _cold_grading() -> None:
    command = [sys.executable, "-m", "grader.cli", "grade", "obstacle_avoidance", str(SOLUTION)]
    peer = [sys.executable, "-c", "import numpy, pymunk, pytest, rich, rosbags.typesys"]
    graded, imported = [], []
    for _ in range(RUNS):
        graded.append(_time(command))
        imported.append(_time(peer))
    full, bare = statistics.median(graded), statistics.median(imported)
    print(f"grading exercise 1 from a cold command: {full:.2f} s (goal 1.5)")
    print(f"  a Python that only imports the libraries: {bare:.2f} s; ratio {full / bare:.1f}")


def _time(command: list[str]) -> float:
    start = time.perf_counter()
    subprocess.run(command, cwd=ROOT, check=True, stdout=subprocess.DEVNULL)
    return time.perf_counter() - start


if __name__ == "__main__":
    main()
