"""Style: functions and closures, no class (rclpy.create_node).

field: all
"""

import math

import rclpy
from geometry_msgs.msg import Twist, Vector3
from rclpy.qos import qos_profile_sensor_data
from rclpy.time import Time
from sensor_msgs.msg import LaserScan
from tf2_ros import Buffer, TransformException, TransformListener


def usable_ahead(scan):
    """Yield the distances [m] that count: ahead of the robot, and meaning something."""
    for i, r in enumerate(scan.ranges):
        theta = scan.angle_min + i * scan.angle_increment
        if abs(math.atan2(math.sin(theta), math.cos(theta))) > math.pi / 2:
            continue
        if r == -math.inf:
            yield 0.0
        elif r == math.inf or scan.range_min <= r <= scan.range_max:
            yield r


def speed_for(distance):
    """Forward speed [m/s]: the one of the first zone whose outer edge [m] lies beyond."""
    zones = {0.5: 0.0, 1.0: 0.15}
    return next((speed for edge, speed in zones.items() if distance < edge), 0.5)


def main(args=None):
    rclpy.init(args=args)
    node = rclpy.create_node("obstacle_avoidance_agent")
    publisher = node.create_publisher(Twist, "/cmd_vel", 1)
    log = node.get_logger()

    frames = Buffer()
    listener = TransformListener(frames, node)

    def on_scan(scan):
        try:
            found = frames.lookup_transform("base_link", scan.header.frame_id, Time())
            turn = found.transform.rotation
            scan.angle_min += 2 * math.atan2(turn.z, turn.w)
        except TransformException:
            log.debug("nobody says how the lidar is mounted", once=True)
        distance = min(usable_ahead(scan), default=0.0)  # blind is as good as touching
        speed = speed_for(distance)
        publisher.publish(Twist(linear=Vector3(x=speed)))
        log.info(f"{distance:.2f} m: {speed:.2f} m/s")

    node.create_subscription(LaserScan, "/scan", on_scan, qos_profile_sensor_data)
    log.info("started")
    try:
        rclpy.spin(node)
    except KeyboardInterrupt:
        listener.unregister()


if __name__ == "__main__":
    main()
