"""Style: a busy flag: scans that come while the model works are dropped; a thread for each other.

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
from sensor_msgs.msg import LaserScan


class DecoupledController(Node):
    def __init__(self):
        super().__init__("decoupled_controller")
        self.declare_parameter("model_path", "velocity_model.pkl")
        self.declare_parameter("max_speed", 0.5)
        self.max_speed = self.get_parameter("max_speed").value
        self.model = self.load_model(self.get_parameter("model_path").value)
        self.prediction = None  # speed [m/s] and stamp of its scan [s]
        self.busy = False
        self.publisher = self.create_publisher(Twist, "/cmd_vel", 10)
        self.create_subscription(LaserScan, "/scan", self.on_scan, qos_profile_sensor_data)
        self.create_timer(0.05, self.on_timer)

    def load_model(self, path):
        try:
            with open(path, "rb") as file:
                return pickle.load(file)
        except Exception as error:
            self.get_logger().error(f"{path} is no model: {error!r}")
            return None

    def on_scan(self, scan):
        if self.busy or self.model is None:
            return
        self.busy = True
        threading.Thread(target=self.infer, args=(scan,), daemon=True).start()

    def infer(self, scan):
        try:
            speed = float(self.model.predict(self.features(scan))[0])
            if not math.isfinite(speed):
                raise ValueError(f"the model says {speed}")
            stamp = scan.header.stamp.sec + scan.header.stamp.nanosec * 1e-9
            self.prediction = (min(max(speed, 0.0), self.max_speed), stamp)
        except Exception as error:
            self.prediction = None
            self.get_logger().error(f"no prediction: {error!r}")
        finally:
            self.busy = False

    def features(self, scan):
        ranges = np.clip(np.array(scan.ranges, dtype=float), -np.inf, scan.range_max)
        ranges[ranges == -np.inf] = scan.range_min
        angles = scan.angle_min + np.arange(ranges.size) * scan.angle_increment
        angles = np.degrees(np.arctan2(np.sin(angles), np.cos(angles)))
        good = ranges >= scan.range_min
        front = ranges[good & (abs(angles) <= 60)]
        left, right = ranges[good & (angles > 60)], ranges[good & (angles < -60)]
        return np.array([[front.min(), front.mean(), front.std(), left.min(), right.min()]])

    def on_timer(self):
        command = Twist()
        now = self.get_clock().now().nanoseconds * 1e-9
        prediction = self.prediction
        if prediction is not None and now - prediction[1] <= 0.6:
            command.linear.x = prediction[0]
        self.publisher.publish(command)


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
