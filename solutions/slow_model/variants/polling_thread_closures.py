"""Style: closures instead of a class; a thread that looks for a new scan every 10 ms.

field: all
"""

import math
import pickle
import threading
import time

import rclpy
from geometry_msgs.msg import Twist
from rclpy.executors import ExternalShutdownException
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import LaserScan


def sectors(scan):
    front, left, right = [], [], []
    for i, reading in enumerate(scan.ranges):
        angle = scan.angle_min + i * scan.angle_increment
        if angle >= math.pi:
            angle -= 2 * math.pi
        if math.isinf(reading):
            reading = scan.range_max if reading > 0 else scan.range_min
        if reading > scan.range_max:
            reading = scan.range_max
        if not (scan.range_min <= reading):
            continue
        side = left if angle > math.pi / 3 else right if angle < -math.pi / 3 else front
        side.append(reading)
    return front, left, right


def features(scan):
    front, left, right = sectors(scan)
    mean = sum(front) / len(front)
    std = math.sqrt(sum((reading - mean) ** 2 for reading in front) / len(front))
    return [min(front), mean, std, min(left), min(right)]


def main(args=None):
    rclpy.init(args=args)
    node = rclpy.create_node("decoupled_controller")
    path = node.declare_parameter("model_path", "velocity_model.pkl").value
    max_speed = node.declare_parameter("max_speed", 0.5).value
    publisher = node.create_publisher(Twist, "/cmd_vel", 10)
    log = node.get_logger()
    state = {"scan": None, "speed": 0.0, "stamp": 0.0}

    def on_scan(scan):
        state["scan"] = scan

    def control():
        now = node.get_clock().now().nanoseconds / 1e9
        command = Twist()
        if now - state["stamp"] < 0.6:
            command.linear.x = state["speed"]
        publisher.publish(command)

    def infer(model):
        done = None
        while rclpy.ok():
            scan = state["scan"]
            if scan is done:
                time.sleep(0.01)
                continue
            done = scan
            try:
                speed = float(model.predict([features(scan)])[0])
                assert math.isfinite(speed), f"the model says {speed}"
            except Exception as error:
                log.error(f"no prediction: {error!r}")
                continue
            state["stamp"] = 0.0  # never an old stamp with a new speed, or the other way round
            state["speed"] = max(0.0, min(max_speed, speed))
            state["stamp"] = scan.header.stamp.sec + scan.header.stamp.nanosec / 1e9

    node.create_subscription(LaserScan, "/scan", on_scan, qos_profile_sensor_data)
    node.create_timer(0.05, control)
    try:
        with open(path, "rb") as file:
            model = pickle.load(file)
        threading.Thread(target=infer, args=(model,), daemon=True).start()
    except Exception as error:
        log.error(f"no model in {path}: {error!r}")
    try:
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
