import numpy as np
import rclpy
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Float64

rclpy.init()
node = rclpy.create_node("watcher")
tell = node.create_publisher(Float64, "distance", 1)


def on_scan(scan):
    ranges = np.array(scan.ranges)
    angles = scan.angle_min + scan.angle_increment * np.arange(len(ranges))
    usable = np.isinf(ranges) | ((ranges >= scan.range_min) & (ranges <= scan.range_max))
    seen = ranges[usable & (np.cos(angles) >= -1e-6)]
    if seen.size:
        tell.publish(Float64(data=max(0.0, float(seen.min()))))


node.create_subscription(LaserScan, "scan", on_scan, qos_profile_sensor_data)
rclpy.spin(node)
