"""Style: the callback hands scans to a thread that predicts and publishes.

field: all
"""

import pickle
import queue
import threading

import numpy as np
import rclpy
from geometry_msgs.msg import Twist
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import LaserScan


class Brain:
    """The model and what it is fed with."""

    def __init__(self, path, log):
        self.log = log
        self.model = None
        try:
            with open(path, "rb") as file:
                self.model = pickle.load(file)
        except Exception as error:
            log.error(f"{path} is no model: {error!r}")

    def speed(self, scan):
        """Speed [m/s]; NaN when there is no saying."""
        angles = scan.angle_min + np.arange(len(scan.ranges)) * scan.angle_increment
        angles = (angles + np.pi) % (2 * np.pi) - np.pi
        readings = np.array(scan.ranges)
        readings = np.where(readings == -np.inf, np.float32(scan.range_min), readings)
        good = readings >= np.float32(scan.range_min)
        readings = np.fmin(readings, scan.range_max).astype(float)
        ahead = np.abs(angles) <= np.pi / 3
        sectors = [
            readings[good & s] for s in (ahead, ~ahead & (angles > 0), ~ahead & (angles < 0))
        ]
        if self.model is None or not all(map(len, sectors)):
            return np.nan
        front, left, right = sectors
        row = [np.min(front), np.mean(front), np.std(front), np.min(left), np.min(right)]
        return self.model.predict(np.array([row]))[0]


class Controller(Node):
    def __init__(self):
        super().__init__("ml_velocity_controller")
        path = self.declare_parameter("model_path", "velocity_model.pkl").value
        self.limit = self.declare_parameter("max_speed", 0.5).value
        self.brain = Brain(path, self.get_logger())
        self.scans = queue.Queue()
        self.publisher = self.create_publisher(Twist, "/cmd_vel", 10)
        self.create_subscription(LaserScan, "/scan", self.scans.put, qos_profile_sensor_data)
        threading.Thread(target=self.work, daemon=True).start()

    def work(self):
        while (scan := self.scans.get()) is not None:
            twist = Twist()
            try:
                speed = self.brain.speed(scan)
            except Exception as error:
                self.get_logger().error(repr(error))
                speed = np.nan
            if np.isfinite(speed):
                twist.linear.x = float(max(0.0, min(speed, self.limit)))
            self.publisher.publish(twist)


def main(args=None):
    rclpy.init(args=args)
    node = Controller()
    try:
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        node.scans.put(None)
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
