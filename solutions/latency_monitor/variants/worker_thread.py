"""Style: a worker thread predicts and publishes; a dataclass writes the report.

field: all
"""

import math
import pickle
import queue
import threading
import time
from collections import deque
from dataclasses import asdict, dataclass

import numpy as np
import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import Twist
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import LaserScan


@dataclass(frozen=True)
class Profile:
    count: int
    mean_ms: float
    p50_ms: float
    p95_ms: float
    p99_ms: float
    max_ms: float
    deadline_ms: float
    missed: int

    @classmethod
    def of(cls, latencies: list[float], deadline: float) -> "Profile":
        some = np.array(latencies or [0.0])
        late = int(np.sum(some > deadline)) if latencies else 0
        p50, p95, p99 = (round(float(x), 3) for x in np.percentile(some, [50, 95, 99]))
        return cls(len(latencies), some.mean(), p50, p95, p99, some.max(), deadline, late)

    @property
    def level(self) -> bytes:
        if not self.count:
            return DiagnosticStatus.STALE
        if not self.missed:
            return DiagnosticStatus.OK
        in_time = self.p95_ms <= self.deadline_ms
        return DiagnosticStatus.WARN if in_time else DiagnosticStatus.ERROR


class ProfiledController(Node):
    def __init__(self) -> None:
        super().__init__("profiled_controller")
        path = self.declare_parameter("model_path", "velocity_model.pkl").value
        self.max_speed = self.declare_parameter("max_speed", 0.5).value
        self.deadline = self.declare_parameter("deadline_ms", 100.0).value
        self.latencies: deque[float] = deque(maxlen=100)
        self.scans: queue.SimpleQueue[LaserScan] = queue.SimpleQueue()
        self.model = None
        try:
            with open(path, "rb") as file:
                self.model = pickle.load(file)
        except Exception as error:
            self.get_logger().error(f"{error!r}")
        self.cmd_vel = self.create_publisher(Twist, "/cmd_vel", 10)
        self.diagnostics = self.create_publisher(DiagnosticArray, "/diagnostics", 10)
        self.create_subscription(LaserScan, "/scan", self.scans.put, qos_profile_sensor_data)
        self.create_timer(1.0, self.report_callback)
        threading.Thread(target=self.work, daemon=True).start()

    def work(self) -> None:
        while True:
            scan = self.scans.get()
            twist = Twist()
            try:
                row = self.features(scan)
                before = time.perf_counter()
                speed = float(self.model.predict(row)[0])
                self.latencies.append(1000.0 * (time.perf_counter() - before))
                if math.isfinite(speed):
                    twist.linear.x = float(np.clip(speed, 0.0, self.max_speed))
            except Exception as error:
                self.get_logger().error(f"{error!r}")
            self.cmd_vel.publish(twist)

    @staticmethod
    def features(scan: LaserScan) -> np.ndarray:
        kept: dict[int, list[float]] = {-1: [], 0: [], 1: []}
        for i, value in enumerate(scan.ranges):
            if value != value:
                continue
            value = scan.range_min if value == -math.inf else min(value, scan.range_max)
            if value >= scan.range_min:
                turn = scan.angle_min + scan.angle_increment * i
                x, y = math.cos(turn), math.sin(turn)
                kept[0 if x >= 0.5 - 1e-9 else 1 if y > 0 else -1].append(value)
        front = np.array(kept[0])
        return np.array([[front.min(), front.mean(), front.std(), min(kept[1]), min(kept[-1])]])

    def report_callback(self) -> None:
        profile = Profile.of(list(self.latencies), self.deadline)
        status = DiagnosticStatus(level=profile.level, name="profiled_controller: inference")
        for key, value in asdict(profile).items():
            status.values.append(KeyValue(key=key, value=f"{value:.2f}"))
        message = DiagnosticArray()
        message.status.append(status)
        self.diagnostics.publish(message)


def main(args=None) -> None:
    rclpy.init(args=args)
    node = ProfiledController()
    try:
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
