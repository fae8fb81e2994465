"""Style: a careful beginner, one long timer callback with ifs, times in seconds from time.time().

field: field_lds01, field_wide_lidar, field_mirrored_world, field_speckle, field_lost_scans
"""

import math
import time

import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import Twist
from rclpy.node import Node
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Bool


class MySupervisor(Node):
    def __init__(self):
        super().__init__("safety_supervisor")
        self.pub = self.create_publisher(Twist, "/cmd_vel", 10)
        self.diag = self.create_publisher(DiagnosticArray, "/diagnostics", 10)
        self.create_subscription(Twist, "/cmd_vel_raw", self.got_command, 10)
        self.create_subscription(LaserScan, "/scan", self.got_scan, 10)
        self.create_subscription(Bool, "/e_stop", self.got_stop, 10)
        self.timer = self.create_timer(0.05, self.loop)
        self.stopped = False
        self.v = 0.0
        self.w = 0.0
        self.good = True
        self.command_at = 0.0  # long ago
        self.scan_at = 0.0
        self.blind = True
        self.nearest = 0.0
        self.last_v = 0.0
        self.last_reason = ""
        self.last_report = 0.0

    def got_stop(self, msg):
        self.stopped = msg.data

    def got_command(self, msg):
        self.command_at = time.time()
        self.v = msg.linear.x
        self.w = msg.angular.z
        self.good = True
        for number in [
            msg.linear.x,
            msg.linear.y,
            msg.linear.z,
            msg.angular.x,
            msg.angular.y,
            msg.angular.z,
        ]:
            if math.isnan(number) or math.isinf(number):
                self.good = False

    def got_scan(self, msg):
        self.scan_at = time.time()
        self.blind = True
        self.nearest = 1000.0
        angle = msg.angle_min
        for r in msg.ranges:
            a = angle
            while a > math.pi:
                a = a - 2 * math.pi
            angle = angle + msg.angle_increment
            if a < -math.pi / 2 or a > math.pi / 2:
                continue
            if math.isnan(r):
                continue
            if r == float("inf"):
                self.blind = False
                continue
            if r == float("-inf"):
                r = 0.0
            elif r < msg.range_min or r > msg.range_max:
                continue
            self.blind = False
            if r < self.nearest:
                self.nearest = r

    def loop(self):
        now = time.time()
        v = 0.0
        w = 0.0
        if self.stopped:
            reason = "e_stop"
        elif not self.good:
            reason = "bad_command"
        elif now - self.command_at > 0.5:
            reason = "stale_command"
        elif now - self.scan_at > 0.5 or self.blind:
            reason = "stale_scan"
        else:
            v = self.v
            w = self.w
            reason = "ok"
            if w > 1.9:
                w = 1.9
                reason = "limited"
            if w < -1.9:
                w = -1.9
                reason = "limited"
            if self.nearest < 0.5 and self.v > 0:
                v = 0.0
                reason = "obstacle"
            else:
                if v > 0.5:
                    v = 0.5
                    reason = "limited"
                if v < -0.5:
                    v = -0.5
                    reason = "limited"
                start = self.last_v
                if start < 0:
                    start = 0.0
                if v > start + 0.045:
                    v = start + 0.045
                    reason = "limited"
        self.last_v = v

        t = Twist()
        t.linear.x = v
        t.angular.z = w
        self.pub.publish(t)

        if reason != self.last_reason or now - self.last_report > 0.9:
            s = DiagnosticStatus()
            if reason == "ok":
                s.level = DiagnosticStatus.OK
            elif reason == "limited" or reason == "obstacle":
                s.level = DiagnosticStatus.WARN
            else:
                s.level = DiagnosticStatus.ERROR
            s.name = "my supervisor"
            s.message = reason
            d = DiagnosticArray()
            d.header.stamp = self.get_clock().now().to_msg()
            d.status.append(s)
            self.diag.publish(d)
            self.last_reason = reason
            self.last_report = now


def main(args=None):
    rclpy.init(args=args)
    node = MySupervisor()
    rclpy.spin(node)
    node.destroy_node()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
