"""Style: plain lists and loops, and percentiles by hand.

field: all
"""

import math
import pickle
import time

import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import Twist
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import LaserScan


def percentile(numbers, percent):
    ordered = sorted(numbers)
    place = percent / 100 * (len(ordered) - 1)
    below = int(place)
    above = min(below + 1, len(ordered) - 1)
    part = place - below
    return ordered[below] * (1 - part) + ordered[above] * part


class ProfiledController(Node):
    def __init__(self):
        super().__init__("profiled_controller")
        self.declare_parameter("model_path", "velocity_model.pkl")
        self.declare_parameter("max_speed", 0.5)
        self.declare_parameter("deadline_ms", 100.0)
        self.max_speed = self.get_parameter("max_speed").value
        self.deadline = self.get_parameter("deadline_ms").value
        self.model = None
        try:
            with open(self.get_parameter("model_path").value, "rb") as file:
                self.model = pickle.load(file)
        except Exception as e:
            self.get_logger().error("The model could not be loaded: " + str(e))
        self.times = []
        self.cmd_pub = self.create_publisher(Twist, "/cmd_vel", 10)
        self.diag_pub = self.create_publisher(DiagnosticArray, "/diagnostics", 10)
        self.create_subscription(LaserScan, "/scan", self.scan_callback, qos_profile_sensor_data)
        self.create_timer(1.0, self.timer_callback)

    def get_features(self, scan):
        front = []
        left = []
        right = []
        for i in range(len(scan.ranges)):
            r = scan.ranges[i]
            if math.isnan(r):
                continue
            if r > scan.range_max:
                r = scan.range_max
            if r == -math.inf:
                r = scan.range_min
            if r < scan.range_min:
                continue
            angle = math.degrees(scan.angle_min + i * scan.angle_increment)
            if angle > 180:
                angle = angle - 360
            if -60 <= angle <= 60:
                front.append(r)
            elif angle > 60:
                left.append(r)
            else:
                right.append(r)
        if front == [] or left == [] or right == []:
            return None
        mean = sum(front) / len(front)
        variance = 0.0
        for r in front:
            variance = variance + (r - mean) ** 2 / len(front)
        return [min(front), mean, variance**0.5, min(left), min(right)]

    def scan_callback(self, scan):
        twist = Twist()
        features = self.get_features(scan)
        if self.model is not None and features is not None:
            try:
                before = time.perf_counter()
                speed = float(self.model.predict([features])[0])
                after = time.perf_counter()
                self.times.append((after - before) * 1000)
                if len(self.times) > 100:
                    self.times.pop(0)
                if not math.isnan(speed) and not math.isinf(speed):
                    if speed < 0.0:
                        speed = 0.0
                    if speed > self.max_speed:
                        speed = self.max_speed
                    twist.linear.x = speed
                else:
                    self.get_logger().error("The model said " + str(speed))
            except Exception as e:
                self.get_logger().error("The model raised " + str(e))
        self.cmd_pub.publish(twist)

    def timer_callback(self):
        status = DiagnosticStatus()
        status.name = "profiled_controller: inference"
        missed = 0
        for t in self.times:
            if t > self.deadline:
                missed = missed + 1
        values = {"count": len(self.times), "deadline_ms": self.deadline, "missed": missed}
        if len(self.times) == 0:
            status.level = DiagnosticStatus.STALE
            for key in ["mean_ms", "p50_ms", "p95_ms", "p99_ms", "max_ms"]:
                values[key] = 0.0
        else:
            values["mean_ms"] = sum(self.times) / len(self.times)
            values["p50_ms"] = percentile(self.times, 50)
            values["p95_ms"] = percentile(self.times, 95)
            values["p99_ms"] = percentile(self.times, 99)
            values["max_ms"] = max(self.times)
            if missed == 0:
                status.level = DiagnosticStatus.OK
            elif values["p95_ms"] <= self.deadline:
                status.level = DiagnosticStatus.WARN
            else:
                status.level = DiagnosticStatus.ERROR
        for key in values:
            status.values.append(KeyValue(key=key, value=str(values[key])))
        message = DiagnosticArray()
        message.header.stamp = self.get_clock().now().to_msg()
        message.status.append(status)
        self.diag_pub.publish(message)


def main(args=None):
    rclpy.init(args=args)
    node = ProfiledController()
    try:
        rclpy.spin(node)
    except KeyboardInterrupt:
        pass
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
