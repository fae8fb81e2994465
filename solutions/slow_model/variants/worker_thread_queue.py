"""Style: a queue.Queue of size one, whose old scan makes way for the new one.

field: all
"""

import math
import pickle
import queue
import threading

import numpy as np
import rclpy
from geometry_msgs.msg import Twist
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import QoSProfile, QoSReliabilityPolicy
from sensor_msgs.msg import LaserScan


class DecoupledController(Node):
    def __init__(self) -> None:
        super().__init__("decoupled_controller")
        self.max_speed = self.declare_parameter("max_speed", 0.5).value
        path = self.declare_parameter("model_path", "velocity_model.pkl").value
        try:
            with open(path, "rb") as file:
                self.model = pickle.load(file)
        except Exception as error:
            self.get_logger().error(f"{path} cannot be loaded ({error})")
            self.model = None
        self.scans: queue.Queue[LaserScan | None] = queue.Queue(maxsize=1)
        self.result = (0.0, -math.inf)  # speed, stamp of its scan [s]
        self.publisher = self.create_publisher(Twist, "/cmd_vel", 5)
        qos = QoSProfile(depth=5, reliability=QoSReliabilityPolicy.BEST_EFFORT)
        self.create_subscription(LaserScan, "/scan", self.scan_callback, qos)
        self.create_timer(0.05, self.control_callback)
        self.worker = threading.Thread(target=self.work)
        self.worker.start()

    def scan_callback(self, scan: LaserScan) -> None:
        try:
            self.scans.get_nowait()
        except queue.Empty:
            pass
        self.scans.put_nowait(scan)

    def work(self) -> None:
        while (scan := self.scans.get()) is not None:
            stamp = scan.header.stamp.sec + scan.header.stamp.nanosec / 1e9
            try:
                speed = self.ask(scan)
            except Exception as error:
                self.get_logger().error(repr(error))
            else:
                self.result = (speed, stamp)

    def ask(self, scan: LaserScan) -> float:
        r = np.asarray(scan.ranges, dtype=np.float64)
        r = np.where(r == -np.inf, scan.range_min, np.minimum(r, scan.range_max))
        theta = np.arange(r.size) * scan.angle_increment + scan.angle_min
        theta = np.degrees(np.arctan2(np.sin(theta), np.cos(theta)))
        with np.errstate(invalid="ignore"):
            keep = r >= scan.range_min
        r, theta = r[keep], theta[keep]
        front = r[np.abs(theta) <= 60]
        row = [front.min(), front.mean(), front.std(), r[theta > 60].min(), r[theta < -60].min()]
        speed = float(self.model.predict(np.array([row]))[0])
        if not np.isfinite(speed):
            raise ValueError(f"the model predicts {speed}")
        return min(self.max_speed, max(0.0, speed))

    def control_callback(self) -> None:
        speed, stamp = self.result
        message = Twist()
        if self.get_clock().now().nanoseconds / 1e9 - stamp < 0.6:
            message.linear.x = speed
        self.publisher.publish(message)

    def stop(self) -> None:
        try:
            self.scans.get_nowait()
        except queue.Empty:
            pass
        self.scans.put(None)


def main(args=None) -> None:
    rclpy.init(args=args)
    node = DecoupledController()
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    try:
        executor.spin()
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        node.stop()
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
