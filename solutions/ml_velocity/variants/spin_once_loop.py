"""Style: the node only keeps the newest scan, a spin_once loop in main thinks and drives.

field: all
"""

import pickle

import numpy as np
import rclpy
from geometry_msgs.msg import Twist
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import LaserScan

EDGE = 60.0  # [°]


class Robot(Node):
    """Eyes, wheels, and a model."""

    def __init__(self):
        super().__init__("ml_velocity_controller")
        self.model_path = self.declare_parameter("model_path", "velocity_model.pkl").value
        self.max_speed = self.declare_parameter("max_speed", 0.5).value
        self.model = self.load()
        self.scan = None
        self.wheels = self.create_publisher(Twist, "/cmd_vel", 10)
        self.create_subscription(LaserScan, "/scan", self.see, qos_profile_sensor_data)

    def load(self):
        try:
            with open(self.model_path, "rb") as file:
                return pickle.Unpickler(file).load()
        except Exception as error:
            self.get_logger().error(f"{type(error).__name__}: {error}")

    def see(self, scan):
        self.scan = scan

    def drive(self, speed):
        twist = Twist()
        twist.linear.x = float(speed)
        self.wheels.publish(twist)


def sectors(scan):
    """Dictionary of sector name: usable readings [m]."""
    found = {"front": [], "left": [], "right": []}
    angle = np.degrees(scan.angle_min)
    for reading in scan.ranges:
        wrapped = (angle + 180.0) % 360.0 - 180.0
        angle += np.degrees(scan.angle_increment)
        if reading == -np.inf:
            reading = scan.range_min
        if reading >= scan.range_min:
            name = "front" if abs(wrapped) <= EDGE else "left" if wrapped > 0 else "right"
            found[name].append(min(reading, scan.range_max))
    return found


def think(robot, scan):
    seen = sectors(scan)
    if robot.model is None or not all(seen.values()):
        return 0.0
    front = np.array(seen["front"])
    features = (front.min(), front.mean(), front.std(), min(seen["left"]), min(seen["right"]))
    try:
        speed = robot.model.predict(np.array([features]))[0]
    except Exception as error:
        robot.get_logger().error(f"the model failed: {error}")
        return 0.0
    return np.clip(speed, 0.0, robot.max_speed) if np.isfinite(speed) else 0.0


def main(args=None):
    rclpy.init(args=args)
    robot = Robot()
    try:
        while rclpy.ok():
            rclpy.spin_once(robot)
            scan, robot.scan = robot.scan, None
            if scan is not None:
                robot.drive(think(robot, scan))
    except KeyboardInterrupt:
        pass
    finally:
        robot.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
