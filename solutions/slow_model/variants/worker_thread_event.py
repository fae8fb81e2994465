"""Style: one worker thread that an Event wakes; rclpy.spin for all the rest.

field: all
"""

import math
import pickle
import threading

import numpy as np
import rclpy
from geometry_msgs.msg import Twist
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from rclpy.time import Time
from sensor_msgs.msg import LaserScan


class DecoupledController(Node):
    def __init__(self):
        super().__init__("decoupled_controller")
        self.declare_parameter("model_path", "velocity_model.pkl")
        self.declare_parameter("max_speed", 0.5)
        self.max_speed = self.get_parameter("max_speed").value
        self.model = None
        try:
            with open(self.get_parameter("model_path").value, "rb") as file:
                self.model = pickle.load(file)
        except Exception as error:
            self.get_logger().error(f"cannot load the model: {error}")

        self.lock = threading.Lock()
        self.newest_scan = None
        self.speed = 0.0
        self.scan_time = None
        self.wake_up = threading.Event()

        self.publisher = self.create_publisher(Twist, "/cmd_vel", 10)
        self.create_subscription(LaserScan, "/scan", self.scan_callback, qos_profile_sensor_data)
        self.create_timer(0.05, self.control_callback)
        if self.model is not None:
            threading.Thread(target=self.work, daemon=True).start()

    def scan_callback(self, scan):
        with self.lock:
            self.newest_scan = scan
        self.wake_up.set()

    def work(self):
        while rclpy.ok():
            self.wake_up.wait()
            self.wake_up.clear()
            with self.lock:
                scan = self.newest_scan
            try:
                prediction = float(self.model.predict([self.features(scan)])[0])
            except Exception as error:
                self.get_logger().error(f"inference failed: {error}")
                continue
            if math.isfinite(prediction):
                with self.lock:
                    self.speed = float(np.clip(prediction, 0.0, self.max_speed))
                    self.scan_time = Time.from_msg(scan.header.stamp)
            else:
                self.get_logger().error(f"the model said {prediction}")

    def features(self, scan):
        front, left, right = [], [], []
        for i, r in enumerate(scan.ranges):
            if r == -math.inf:
                r = scan.range_min
            r = min(r, scan.range_max) if r == r else r
            if not r >= scan.range_min:
                continue
            angle = math.remainder(scan.angle_min + i * scan.angle_increment, math.tau)
            if abs(angle) <= math.pi / 3:
                front.append(r)
            elif angle > 0:
                left.append(r)
            else:
                right.append(r)
        return [min(front), np.mean(front), np.std(front), min(left), min(right)]

    def control_callback(self):
        twist = Twist()
        with self.lock:
            if self.scan_time is not None:
                age = (self.get_clock().now() - self.scan_time).nanoseconds * 1e-9
                if age < 0.6:
                    twist.linear.x = self.speed
        self.publisher.publish(twist)


def main(args=None):
    rclpy.init(args=args)
    node = DecoupledController()
    try:
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
