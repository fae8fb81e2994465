"""Style: no class; functions, closures, numpy's masked arrays, and joblib to load the model.

field: all
"""

import joblib
import numpy as np
import rclpy
from geometry_msgs.msg import Twist, Vector3
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import LaserScan


def features(scan):
    """(1, 5) features; masked where a sector is blind."""
    theta = scan.angle_min + scan.angle_increment * np.arange(len(scan.ranges))
    theta = np.degrees(np.arctan2(np.sin(theta), np.cos(theta)))
    reading = np.asarray(scan.ranges, dtype=np.float64)
    reading[np.isneginf(reading)] = scan.range_min
    reading[reading > scan.range_max] = scan.range_max
    useless = ~(reading >= scan.range_min)
    front = np.ma.array(reading, mask=useless | (abs(theta) > 60))
    left = np.ma.array(reading, mask=useless | (theta <= 60))
    right = np.ma.array(reading, mask=useless | (theta >= -60))
    if not (front.count() and left.count() and right.count()):
        return None
    return np.array([[front.min(), front.mean(), front.std(), left.min(), right.min()]])


def main(args=None):
    rclpy.init(args=args)
    node = rclpy.create_node("ml_velocity_controller")
    log = node.get_logger()
    path = node.declare_parameter("model_path", "velocity_model.pkl").value
    limit = node.declare_parameter("max_speed", 0.5).value
    try:
        model = joblib.load(path)
    except Exception as error:
        log.fatal(f"{path}: {error}")
        model = None
    publisher = node.create_publisher(Twist, "/cmd_vel", 1)

    def speed_for(scan):
        x = features(scan)
        if model is None or x is None:
            return 0.0
        try:
            (said,) = model.predict(x)
        except Exception as error:
            log.error(f"model: {error}")
            return 0.0
        return float(np.clip(said, 0.0, limit)) if np.isfinite(said) else 0.0

    def on_scan(scan):
        publisher.publish(Twist(linear=Vector3(x=speed_for(scan))))

    node.create_subscription(LaserScan, "/scan", on_scan, qos_profile_sensor_data)
    try:
        rclpy.spin(node)
    except KeyboardInterrupt:
        pass


if __name__ == "__main__":
    main()
